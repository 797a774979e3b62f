# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The spanning tree of Huber and Hebert 2003: all pairs are registered, the best of them kept.

The accepted pairs are the edges of the model graph. In falling order of their inliers (points of
both views that overlap) an edge joins two parts, unless views that come to lie together then are
not surface consistent: the greedy form of their search, which for additive weights finds the best
tree of consistent pairs where all are right. Poses along a tree cannot contradict each other.

Published for one object; each connected component of the accepted pairs is one here, which is the
generous reading for several.
"""

from itertools import combinations

import numpy as np
from ros_rops.bench.multiview import Job
from ros_rops.bench.rivals.strategy import Strategy
from ros_rops.bench.rivals.view_graph import Book, GraphSession, Pairs, Part
from ros_rops.core.types import Floats, Status


def model_graph(pairs: Pairs) -> list[tuple[int, int, Floats]]:
    """Register all pairs; return the accepted ones as (i, j, `T_j_i`), most inliers first."""
    edges = []
    for i, j in combinations(range(len(pairs.views)), 2):
        result = pairs.result(i, j)
        if result.status is Status.PLACED and result.T_target_source is not None:
            points = sum(len(pairs.views[k].mesh.vertices) for k in (i, j))
            inliers = result.numbers['overlap'] * points
            edges.append((-inliers, i, j, result.T_target_source))
    return [(i, j, T) for _, i, j, T in sorted(edges, key=lambda edge: edge[:3])]


def spanning_trees(pairs: Pairs) -> list[Part]:
    """Join views along the best consistent pairs; returns the parts of two or more views."""
    of: dict[int, Part] = {k: {k: np.eye(4)} for k in range(len(pairs.views))}
    for i, j, T_j_i in model_graph(pairs):
        part, other = of[j], of[i]
        if part is other:
            continue
        T_part_other = part[j] @ T_j_i @ np.linalg.inv(other[i])
        moved = {k: T_part_other @ pose for k, pose in other.items()}
        if not pairs.agree(part, moved):
            continue
        part.update(moved)
        of.update(dict.fromkeys(moved, part))
    parts = {id(part): part for part in of.values()}
    return [part for part in parts.values() if len(part) > 1]


def open_spanning_tree(job: Job, book: Book | None = None) -> GraphSession:
    """Return the session of a job."""
    return GraphSession(job, spanning_trees, book)


SPANNING_TREE = Strategy(
    'spanning tree', 'Huber and Hebert 2003 [9]', open_spanning_tree)
