# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parting what contradicts itself; truth: small graphs drawn by hand."""

import numpy as np
from ros_rops.core.consistency import agreeing_groups
from ros_rops.core.fine_types import EdgeFit, FineResult

NOWHERE = np.eye(4)


def result(count, edges):
    fits = tuple(EdgeFit(a, b, 100, overlap, residual) for a, b, overlap, residual in edges)
    return FineResult((NOWHERE,) * count, (), fits, 0.1, 1.0, 1, True)


def groups(count, edges, limit=0.35):
    return agreeing_groups(result(count, edges), 2.0, lambda a, b: limit)


RING = [(0, 1, 0.5, 0.1), (1, 2, 0.5, 0.12), (2, 3, 0.5, 0.11), (0, 3, 0.4, 0.1)]


def test_a_sound_ring_stays_whole():
    assert groups(4, RING) == [[0, 1, 2, 3]]


def test_a_fold_is_cut_where_it_fits_worst():
    # 0-1-2 and 3-4 fit well within; 2-3 was the way in, 1-3 and 0-4 show that it is wrong.
    edges = [
        (0, 1, 0.6, 0.1), (1, 2, 0.6, 0.1), (0, 2, 0.3, 0.11), (3, 4, 0.6, 0.1),
        (2, 3, 0.3, 0.3), (1, 3, 0.3, 0.6), (0, 4, 0.2, 0.7)]
    assert groups(5, edges) == [[0, 1, 2], [3, 4]]


def test_what_a_pair_may_have_is_no_contradiction():
    edges = [*RING, (0, 2, 0.3, 0.3)]
    assert groups(4, edges) == [[0, 1, 2, 3]]
    assert len(groups(4, edges, limit=0.2)) == 2


def test_hardly_overlapping_views_cannot_contradict():
    assert groups(4, [*RING, (0, 2, 0.02, 5.0)]) == [[0, 1, 2, 3]]


def test_uniformly_worse_data_are_no_contradiction():
    assert groups(4, [(a, b, overlap, 5 * residual) for a, b, overlap, residual in RING],
                  limit=0.0) == [[0, 1, 2, 3]]


def test_no_edges():
    assert groups(3, []) == [[0, 1, 2]]
