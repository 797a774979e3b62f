# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rendered sets of the laboratory; truth: the mesh itself and the angle of the turntable."""

import numpy as np
import pytest
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.core.errors import ParameterError
from ros_rops.core.se3 import move
from ros_rops.recordings.synthetic import Model

CORNERS = np.array([[x, y, z] for x in (0, 2) for y in (0, 1) for z in (0, 3)], dtype=float)
FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]], dtype=np.int32)
BOX = Model(CORNERS, FACES, name='box')


def test_points_under_their_poses_lie_on_the_mesh() -> None:
    found = rendered_set(BOX, views=6, step_deg=60.0, pixels=40)
    assert found.name == 'box_6' and found.reference_kind == 'exact'
    assert list(found.views) == ['box_0', 'box_60', 'box_120', 'box_180', 'box_240', 'box_300']
    for name, view in found.views.items():
        world = move(found.T_world_view[name], view.points)
        gap = np.minimum(np.abs(world), np.abs(world - [2.0, 1.0, 3.0])).min(axis=1)
        assert len(world) > 100 and gap.max() < 1e-9
        assert np.all((world > -1e-9) & (world < np.array([2.0, 1.0, 3.0]) + 1e-9))


def test_neighbours_are_one_step_about_y_apart() -> None:
    found = rendered_set(BOX, views=3, step_deg=15.0, pixels=20)
    first, second, _ = found.T_world_view.values()
    turn = second[:3, :3] @ first[:3, :3].T
    angle = np.deg2rad(15.0)
    expected = [
        [np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    np.testing.assert_allclose(turn, expected, atol=1e-12)
    # The camera stands above the middle and on the side of +z.
    assert first[1, 3] > 0.5 and first[2, 3] > 3.0 and abs(first[0, 3] - 1.0) < 1e-9


def test_noise_moves_points_along_their_rays_by_so_many_dres() -> None:
    clean = rendered_set(BOX, views=2, pixels=60)
    noisy = rendered_set(BOX, views=2, pixels=60, noise_mr=0.5, seed=3)
    again = rendered_set(BOX, views=2, pixels=60, noise_mr=0.5, seed=3)
    other = rendered_set(BOX, views=2, pixels=60, noise_mr=0.5, seed=4)
    name = 'box_0'
    shift = noisy.views[name].points - clean.views[name].points
    assert noisy.dres == clean.dres
    across = np.cross(shift, clean.views[name].points)
    assert np.abs(across).max() < 1e-9
    assert 0.3 < np.sqrt((shift ** 2).sum(axis=1).mean()) / clean.dres < 0.6
    np.testing.assert_array_equal(noisy.views[name].points, again.views[name].points)
    assert not np.array_equal(noisy.views[name].points, other.views[name].points)


def test_unusable_numbers_are_named() -> None:
    for wrong in ({'views': 1}, {'pixels': 3}, {'noise_mr': -1.0}, {'noise_mr': float('nan')}):
        with pytest.raises(ParameterError, match='views, pixels, noise_mr'):
            rendered_set(BOX, **wrong)
