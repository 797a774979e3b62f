# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Poses turned by 180 degrees. Truth: a known motion, frames that lean to the other side."""

from dataclasses import replace

import numpy as np
import pytest
from reference.surfaces import bumpy_mesh, moved
from ros_rops.core.config import Config, MatchingConfig
from ros_rops.core.hypotheses import half_turned, matched
from ros_rops.core.pairwise import register
from ros_rops.core.se3 import move, rigid
from ros_rops.core.surface import make_surface
from ros_rops.core.types import SensorModel
from scipy.spatial.transform import Rotation

TURN = Rotation.from_euler('xyz', [20, -30, 40], degrees=True).as_matrix()
SHIFT = np.array([3.0, -2.0, 1.0])
MOTION = rigid(TURN, SHIFT)
NEAREST = replace(Config(), matching=MatchingConfig(neighbours=1))


@pytest.fixture(scope='module')
def sides():
    mesh = bumpy_mesh()
    return tuple(
        make_surface('', one, SensorModel('unknown'), Config(), threads=1)
        for one in (mesh, moved(mesh, TURN, SHIFT)))


def leaning_over(surface):
    """Turn all frames of a surface by 180 degrees about z, as if it had been seen by halves."""
    features = surface.features
    about_z = np.array([[-1.0], [-1.0], [1.0]])
    return replace(surface, features=replace(features, lrfs=features.lrfs * about_z))


def right(transforms):
    return np.isclose(transforms, MOTION, atol=1e-3).all(axis=(1, 2))


def test_frames_that_lean_over_propose_the_right_pose_half_turned(sides):
    source, target = sides[0], leaning_over(sides[1])
    pairs = matched(source, target, NEAREST, threads=1)
    assert not right(pairs.transforms).any()
    assert right(half_turned(target, pairs)).mean() > 0.5


def test_keypoints_stay_where_they_met(sides):
    source, target = sides
    pairs = matched(source, target, NEAREST, threads=1)
    turned = half_turned(target, pairs)
    for k in range(0, len(turned), 50):
        point = source.features.positions[pairs.matches.source[k]]
        assert move(turned[k], point) == pytest.approx(move(pairs.transforms[k], point))
        relative = Rotation.from_matrix(turned[k, :3, :3] @ pairs.transforms[k, :3, :3].T)
        assert np.degrees(relative.magnitude()) == pytest.approx(180)


@pytest.mark.parametrize(('half_turns', 'times'), [(True, 2), (False, 1)])
def test_registration_tries_both(sides, half_turns, times):
    source, target = sides
    config = replace(Config(), pairwise=replace(
        Config().pairwise, half_turns=half_turns, random_starts=0))
    # Neighbouring views fit plainly: each feature's nearest match is all that was tried.
    pairs = matched(source, target, replace(config, matching=replace(
        config.matching, neighbours=1, both_directions=False)), threads=1)
    numbers = register(source, target, config, threads=1).numbers
    assert numbers['matches'] == len(pairs.matches)
    assert numbers['hypotheses'] == times * len(pairs.matches)


def test_no_matches_have_no_half_turns(sides):
    target = sides[1]
    empty = replace(target.features, **{
        name: getattr(target.features, name)[:0]
        for name in ('indices', 'positions', 'lrfs', 'descriptors')})
    nothing = replace(target, features=empty)
    assert half_turned(nothing, matched(sides[0], nothing, Config())).shape == (0, 4, 4)
