# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Open3D's way to many views of one object: all pairs, then a pose graph.

All pairs by FPFH and RANSAC, refined by point-to-plane ICP; the graph starts from the spanning
tree of the best fitting pairs and is optimized with its switchable edges (EVALUATION). It knows
neither several objects nor views that do not belong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from ros_rops.bench.peers.open3d_pairs import ICP_DRES, PeerView, prepare_view, ransac, refine
from ros_rops.core.types import Floats, RangeView
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

# Pairs that fit less are not even offered to the graph.
LEAST_FITNESS = 0.1
Fits = Mapping[tuple[int, int], tuple[float, Floats]]


@dataclass(frozen=True, slots=True)
class Way:
    """
    How Open3D is run.

    Parameters
    ----------
    thinned : bool
        ICP and the graph see the voxelized clouds, as in Open3D's tutorial of multiway
        registration, instead of all points: quicker, less exact.
    """

    thinned: bool = False

    def cloud(self, view: PeerView) -> PeerView:
        """Return the view with the points that ICP and the graph see."""
        if not self.thinned:
            return view
        return PeerView(view.thinned, view.thinned, view.features)


def start_poses(count: int, fits: Fits) -> list[Floats]:
    """
    Chain the best fitting pairs to `T_first_view` (4, 4) of each view.

    Parameters
    ----------
    count : int
    fits : mapping of (i, j) to (fitness, T_j_i)

    Returns
    -------
    list of (4, 4) float64
        The identity for views that no pair reaches.
    """
    poses = [np.eye(4) for _ in range(count)]
    if not fits:
        return poses
    rows, columns = np.array(list(fits)).T
    costs = [1.0 + 1e-6 - fitness for fitness, _ in fits.values()]
    tree = minimum_spanning_tree(coo_matrix((costs, (rows, columns)), shape=(count, count)))
    order, parents = breadth_first_order(tree, 0, directed=False)
    for child in order[1:]:
        parent = int(parents[child])
        T = fits[child, parent][1] if (child, parent) in fits else np.linalg.inv(
            fits[parent, child][1])
        poses[child] = poses[parent] @ T
    return poses


def optimized(views: Sequence[PeerView], fits: Fits, dres: float) -> list[Floats]:
    """Optimize the pose graph; returns `T_object_view` (4, 4) of each view."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    graph = registration.PoseGraph()
    for T in start_poses(len(views), fits):
        graph.nodes.append(registration.PoseGraphNode(T))
    reach = ICP_DRES[-1] * dres
    for (i, j), (_, T) in fits.items():
        information = registration.get_information_matrix_from_point_clouds(
            views[i].points, views[j].points, reach, T)
        graph.edges.append(registration.PoseGraphEdge(i, j, T, information, uncertain=True))
    # Every edge may be switched off, which Open3D warns of.
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        registration.global_optimization(
            graph, registration.GlobalOptimizationLevenbergMarquardt(),
            registration.GlobalOptimizationConvergenceCriteria(),
            registration.GlobalOptimizationOption(
                max_correspondence_distance=reach, edge_prune_threshold=0.25, reference_node=0))
    return [np.array(node.pose) for node in graph.nodes]


def fit(source: PeerView, target: PeerView, dres: float, way: Way) -> Any:
    """Register a pair by RANSAC and two rounds of point-to-plane ICP."""
    start = ransac(source, target, dres)
    return refine(
        way.cloud(source), way.cloud(target), start.transformation, dres, plane=True)


def multiway(views: Sequence[RangeView], dres: float, way: Way) -> list[Floats]:
    """
    Register views of one object.

    Parameters
    ----------
    views : sequence of RangeView
    dres : float
        Mesh resolution of the set, by which Open3D's lengths are chosen.
    way : Way

    Returns
    -------
    list of (4, 4) float64
        `T_object_view` of each view; Open3D places every one.
    """
    prepared = [prepare_view(view, dres, plane=not way.thinned) for view in views]
    fits = {}
    for i, j in combinations(range(len(prepared)), 2):
        result = fit(prepared[i], prepared[j], dres, way)
        if result.fitness >= LEAST_FITNESS:
            fits[i, j] = (float(result.fitness), np.array(result.transformation))
    return optimized([way.cloud(view) for view in prepared], fits, dres)
