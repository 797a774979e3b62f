# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Assembled clouds. Truth: what comes out is what went in, moved by exact poses."""

from dataclasses import replace
import tracemalloc

import numpy as np
import pytest
from reference.updates import Station
from ros_rops.live.assembly import Assembly, GREY, Piece, pieces_of
from ros_rops.live.places import poses

MANY = 10**9


def _pieces(station):
    known = poses(station.update())
    return [piece for object_id in known for piece in pieces_of(known, object_id)]


def _rows(cloud, view_id):
    return cloud.words[cloud.words.view(np.int32)[:, -1] == view_id]


def _colors(cloud, rows):
    packed = rows[:, cloud.fields.index('rgb')].copy().view(np.uint32)
    return np.stack([packed >> 16, packed >> 8 & 255, packed & 255], axis=1)


@pytest.mark.parametrize('units', ['m', 'mm', 'unknown'])
def test_every_point_comes_out_at_its_place(units):
    station = Station(units=units)
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2)):
        station.see(name, object_id)
    assembly = Assembly(0.0, MANY)
    assembly.take(station.update())
    cloud = assembly.cloud(_pieces(station))
    assert cloud.fields == (
        'x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z', 'rgb', 'object_id', 'view_id')
    assert len(cloud.words) == 4 * station.count
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2)):
        T, view = station.T_object_view(object_id, name), station.views[name]
        rows = _rows(cloud, station.numbers[name])
        assert (rows.view(np.int32)[:, -2] == object_id).all()
        expected = view.points / station.scale @ T[:3, :3].T + T[:3, 3]
        # In any order: by the coordinates, which differ.
        ours, theirs = np.lexsort(rows[:, :3].T), np.lexsort(expected.astype(np.float32).T)
        np.testing.assert_allclose(rows[ours, :3], expected[theirs], atol=3e-7)
        normals = station.prepared[name].mesh.normals @ T[:3, :3].T
        np.testing.assert_allclose(rows[ours, 3:6], normals[theirs], atol=1e-6)
        np.testing.assert_array_equal(_colors(cloud, rows[ours]), view.colors[theirs])


def test_thinned_points_are_measured_ones_a_spacing_apart():
    station = Station(count=4000)
    station.see('a', 1)
    station.see('b', 1)
    assembly = Assembly(2.0, MANY)
    assembly.take(station.update())
    cloud = assembly.cloud([Piece(1, 'a', np.eye(4))])
    measured = {tuple(point) for point in station.views['a'].points.astype(np.float32)}
    assert {tuple(point) for point in cloud.words[:, :3]} <= measured
    offset = station.views['a'].points - station.views['a'].points.min(axis=0)
    assert len(cloud.words) == len(np.unique(np.floor(offset / 0.02), axis=0))


def test_grey_where_some_have_colours_no_field_where_none_has():
    station = Station()
    station.see('a', 1)
    station.colored = False
    station.see('b', 1)
    assembly = Assembly(0.0, MANY)
    assembly.take(station.update())
    cloud = assembly.cloud(_pieces(station))
    assert (_colors(cloud, _rows(cloud, 1)) == GREY).all()
    bare = assembly.cloud([Piece(1, 'b', np.eye(4))])
    assert 'rgb' not in bare.fields and bare.words.shape == (station.count, 8)
    assert (bare.words.view(np.int32)[:, -2:] == (1, 1)).all()


def test_normals_of_a_mesh_coarser_than_its_view_are_the_nearest():
    station = Station()
    station.see('a', 1, coarse=True)
    station.see('b', 1)
    assembly = Assembly(0.0, MANY)
    assembly.take(station.update())
    cloud = assembly.cloud([Piece(1, 'a', np.eye(4))])
    mesh = station.prepared['a'].mesh
    for row in cloud.words[::10]:
        nearest = np.argmin(np.linalg.norm(mesh.vertices - row[:3], axis=1))
        np.testing.assert_allclose(row[3:6], mesh.normals[nearest], atol=1e-6)


def test_never_more_points_than_allowed_and_no_view_left_out():
    station, assembly = Station(count=500), Assembly(0.0, 2000)
    for k in range(20):
        station.see(f'v{k}', 1 + k % 2)
        assembly.take(station.update())
        cloud = assembly.cloud(_pieces(station))
        placed = sum(len(names) for names in station.members.values() if len(names) > 1)
        assert len(cloud.words) <= 2000
        assert len(cloud.words) == 500 * placed or len(cloud.words) > 2000 / 2 ** 0.5 - 40
        counts = np.unique(cloud.words.view(np.int32)[:, -1], return_counts=True)[1]
        assert len(counts) == placed and (counts == counts.max(initial=0)).all()


def test_what_did_not_change_keeps_its_key():
    station, assembly = Station(), Assembly(0.0, MANY)
    for name, object_id in (('a', 1), ('b', 1), ('c', 2), ('d', 2)):
        station.see(name, object_id)

    def keys():
        assembly.take(station.update())
        views = poses(station.update())
        return {number: assembly.key([Piece(number, name, T) for name, T in found.items()])
                for number, found in views.items()}
    before = keys()
    assert keys() == before
    station.see('e', 2)
    after = keys()
    assert after[1] == before[1] and after[2] != before[2]
    station.places['b'] = station.places['b'] @ station.places['b']
    assert keys()[1] != before[1]


def test_a_new_view_under_an_old_name_is_not_the_old_one():
    station, assembly = Station(), Assembly(0.0, MANY)
    for name in 'ab':
        station.see(name, 1)
    for _ in range(2):
        assembly.take(station.update())
        found = assembly.cloud([Piece(1, 'b', np.eye(4))]).words[:, :3]
        expected = station.views['b'].points.astype(np.float32)
        assert sorted(map(tuple, found)) == sorted(map(tuple, expected))
        station.take_back('b')
        station.see('b', 1)


def test_memory_follows_what_is_shown_not_what_there_is():
    station, assembly = Station(count=4000, colored=False), Assembly(0.0, 20_000)
    for k in range(60):
        station.see(f'v{k}', 1)
    full = station.update()
    tracemalloc.start()
    try:
        for k in range(2, 61):
            model = replace(full.objects[0], views=full.objects[0].views[:k])
            assembly.take(replace(full, objects=(model,)))
            assembly.cloud(pieces_of({1: {
                view.name: view.T_object_view for view in model.views}}, 1))
        kept = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    # Of every view the order of its points, four bytes each; rows of 28 bytes of those shown.
    assert kept < 60 * 4000 * 4 + 2 * 20_000 * 28 + 100_000


def test_nothing_placed_is_an_empty_cloud():
    assembly = Assembly(1.0, 1000)
    assembly.take(Station().update())
    assert assembly.cloud([]).words.shape == (0, 8)
