# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's pairwise registration and its preset. Truth: known motions; the paper's numbers."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from reference import bumpy
from ros_rops.bench.settings import derive
from ros_rops.core.errors import ParameterError
from ros_rops.core.pairwise import register
from ros_rops.core.types import RangeView, SensorModel, Status
from ros_rops.kernels.evidence import Evidence
from ros_rops.pipeline.parameters import load_config
from ros_rops.pipeline.prepare import prepare

ROOT = Path(__file__).resolve().parents[2]
PAPER = load_config(ROOT / 'config' / 'paper.yaml')
LOOKS = [(1.0, 0.2, 0.1), (1.0, -0.2, 0.3), (-1.0, 0.1, 0.2)]


@cache
def scene():
    """Return three views of a bumpy ball, the first two from nearby, and their poses."""
    found, poses, resolution = bumpy.views_of(LOOKS, bumps=0.25, count=9000)
    views = []
    for k, (view, pose) in enumerate(zip(found, poses, strict=True)):
        look = -np.array(LOOKS[k]) / np.linalg.norm(LOOKS[k]) @ pose[:3, :3]
        views.append(RangeView(
            f'view{k}', view.points, None, SensorModel('orthographic', direction=tuple(look))))
    surfaces = [prepare(view, PAPER, resolution=resolution).surface for view in views]
    return surfaces, poses


def errors(T, poses):
    """Return degrees and resolutions between T_1_0 and the truth."""
    truth = np.linalg.inv(poses[1]) @ poses[0]
    surface = scene()[0][0]
    cosine = (np.trace(truth[:3, :3].T @ T[:3, :3]) - 1) / 2
    centre = surface.evidence.centre
    gap = (T - truth)[:3, :3] @ centre + (T - truth)[:3, 3]
    return np.degrees(np.arccos(np.clip(cosine, -1, 1))), (
        np.linalg.norm(gap) / surface.resolution)


def test_preset_is_what_the_paper_says():
    stated = {
        'keypoints.method': 'paper', 'keypoints.eigen_ratio': 1.02, 'lrf.method': 'rops',
        'rops.radius_mr': 15.0, 'rops.rotations': 3, 'rops.bins': 5, 'matching.neighbours': 1,
        'matching.both_directions': False, 'ccv.metric': 'euler', 'ccv.angle_rad': 0.2,
        'ccv.distance_mr': 10.0, 'ccv.inlier_mr': 2.0, 'icp.method': 'paper',
        'icp.reject_mr': 2.0, 'evidence.grow_mr': 1.0, 'pairwise.method': 'paper',
        'pairwise.random_starts': 0, 'verdict.overlap_least': 0.5, 'fine.method': 'williams'}
    flat = PAPER.to_flat()
    assert {name: flat[name] for name in stated} == stated


@pytest.mark.parametrize('changes', [
    {}, {'icp.method': 'point_to_plane'}, {'ccv.metric': 'so3'}])
def test_two_views_of_much_overlap_are_registered(changes):
    surfaces, poses = scene()
    stages = []
    result = register(*surfaces[:2], derive(PAPER, changes), lap=stages.append)
    assert result.status is Status.PLACED, result.reason
    degrees, shift = errors(result.T_target_source, poses)
    # The views are sampled at different places, which point to point ICP feels.
    assert degrees < 1.5 and shift < 1.0
    assert stages == ['match', 'ccv', 'icp']
    numbers = result.numbers
    assert numbers['matches'] == numbers['keypoints_source'] == numbers['ccv_groups'] > 100
    assert 0.5 < numbers['overlap'] <= 1.0 and 0 < numbers['residual_mr'] < 1.0
    assert numbers['inliers'] > 100


def test_the_result_does_not_depend_on_threads():
    surfaces, _ = scene()
    poses = [register(*surfaces[:2], PAPER, threads=n).T_target_source for n in (1, 2, 3)]
    assert poses[0].tobytes() == poses[1].tobytes() == poses[2].tobytes()


def test_views_of_opposite_sides_are_refused_by_their_overlap():
    surfaces, _ = scene()
    result = register(surfaces[0], surfaces[2], PAPER)
    assert result.status is Status.REFUSED and result.T_target_source is None
    assert result.numbers['overlap'] <= 0.5 and 'not more than 50%' in result.reason


def test_acceptance_goes_by_the_share_asked_for():
    surfaces, _ = scene()
    overlap = register(*surfaces[:2], PAPER).numbers['overlap']
    for least, status in ((overlap, Status.REFUSED), (overlap - 1e-6, Status.PLACED)):
        config = derive(PAPER, {'verdict.overlap_least': least})
        assert register(*surfaces[:2], config).status is status


def test_only_so_many_groups_are_counted_as_asked_for():
    surfaces, _ = scene()
    result = register(*surfaces[:2], derive(PAPER, {'ccv.verified': 7}))
    assert result.numbers['ccv_groups'] == 7
    with pytest.raises(ParameterError, match='verified'):
        derive(PAPER, {'ccv.verified': 0})


def test_a_side_without_features_is_refused():
    surfaces, _ = scene()
    features = surfaces[0].features
    bare = replace(
        surfaces[0], features=replace(
            features, indices=features.indices[:0], positions=features.positions[:0],
            lrfs=features.lrfs[:0], descriptors=features.descriptors[:0]))
    for pair in ((bare, surfaces[1]), (surfaces[1], bare), (bare, bare)):
        result = register(*pair, PAPER)
        assert result.status is Status.REFUSED and result.T_target_source is None
        assert 'no group' in result.reason and result.numbers['inliers'] == 0


def test_groups_serve_as_hypotheses_of_the_search():
    surfaces, poses = scene()
    config = derive(PAPER, {'pairwise.method': 'verified', 'pairwise.refined': 20})
    scores = {}
    for kind in ('matches', 'ccv'):
        result = register(*surfaces[:2], derive(config, {'pairwise.hypotheses': kind}))
        assert result.status is Status.PLACED, result.reason
        assert max(errors(result.T_target_source, poses)) < 0.5
        scores[kind] = result.numbers['hypotheses']
    assert scores['ccv'] == scores['matches'] > 0


@pytest.mark.parametrize('offset', [0.0, 1e6])
def test_evidence_gives_its_vertices_back(offset):
    rng = np.random.default_rng(3)
    points = rng.uniform(-20, 20, (500, 3)) + offset
    normals = rng.normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rim = rng.random(500) < 0.3
    found = Evidence.of(points, normals, rim, SensorModel(), cell=2.0, reach=2).vertices()
    order = np.lexsort(points.T), np.lexsort(found.points.T)
    assert np.allclose(found.points[order[1]], points[order[0]], rtol=0, atol=1e-5)
    assert found.rim[order[1]].tolist() == rim[order[0]].tolist()
    lengths = np.linalg.norm(found.normals, axis=1)
    assert (np.isclose(lengths, 1, atol=1e-5) | (lengths == 0)).all()
    assert not any(array.flags.writeable for array in found)
