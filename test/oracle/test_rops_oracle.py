# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames and descriptors; truth: the author's toolbox and PCL on PCL's test mesh (BSD)."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.config import LrfConfig, RopsConfig
from ros_rops.core.lrf import compute_lrfs
from ros_rops.core.rops import describe
from ros_rops.core.types import RangeMesh

SHARED = Path(os.environ.get('ROPS_SHARED', Path(__file__).resolve().parents[3] / 'shared'))
ORACLE = SHARED / 'oracle' / 'rops_oracle.npz'

pytestmark = pytest.mark.skipif(
    not ORACLE.is_file(), reason=f'no oracle at {ORACLE}; set ROPS_SHARED to its folder'
)


@pytest.fixture(scope='module')
def oracle():
    with np.load(ORACLE) as data:
        return dict(data)


@pytest.fixture(scope='module')
def mesh(oracle):
    count = len(oracle['vertices'])
    return RangeMesh(
        vertices=oracle['vertices'],
        faces=oracle['faces'],
        normals=np.zeros((count, 3)),
        boundary=np.zeros(count, bool),
        resolution=float(oracle['mesh_resolution']),
    )


def rops_config(oracle, convention):
    radius_mr = float(oracle['support_radius']) / float(oracle['mesh_resolution'])
    return RopsConfig(radius_mr=radius_mr, convention=convention, loose_vertices=True)


def test_frames_equal_the_authors(oracle, mesh):
    radius = float(oracle['support_radius'])
    lrfs, values = compute_lrfs(mesh, oracle['keypoints'], LrfConfig(method='rops'), radius)
    # |R1 - R2| = 2 sqrt(2) sin(angle / 2)
    distance = np.linalg.norm(lrfs - oracle['author_lrf'], axis=(1, 2))
    angle = 2 * np.arcsin(distance / math.sqrt(8))
    assert len(angle) == 40
    assert np.degrees(angle).max() < 0.01
    assert (values[:, 0] >= values[:, 1]).all() and (values[:, 1] >= values[:, 2]).all()


def test_descriptors_equal_the_authors_given_the_frames(oracle, mesh):
    found = describe(
        mesh, oracle['keypoints'], LrfConfig(method='rops'), rops_config(oracle, 'author'),
        lrfs=oracle['author_lrf'],
    )
    assert np.abs(found.descriptors - oracle['author_rops']).max() < 1e-6


def test_descriptors_equal_the_authors_from_the_mesh(oracle, mesh):
    found = describe(
        mesh, oracle['keypoints'], LrfConfig(method='rops'), rops_config(oracle, 'author')
    )
    assert np.abs(found.descriptors - oracle['author_rops']).max() < 1e-6


def test_pcl_convention_correlates_with_pcl(oracle, mesh):
    found = describe(
        mesh, oracle['keypoints'], LrfConfig('rops', 'pcl'), rops_config(oracle, 'pcl')
    )
    for ours, theirs in zip(found.descriptors, oracle['pcl_rops'], strict=True):
        assert np.corrcoef(ours, theirs)[0, 1] > 0.99
