# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Open3D's way to many views of one object: all pairs, then a pose graph.

All pairs by FPFH and RANSAC, refined by point-to-plane ICP; the graph starts from the spanning
tree of the best fitting pairs and is optimized with its switchable edges (EVALUATION). It knows
neither several objects nor views that do not belong.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
import time
from typing import Any

import numpy as np
from ros_rops.bench.evaluate import evaluate, known_views
from ros_rops.bench.judgement import Placement
from ros_rops.bench.peers import ICP_DRES, NORMAL_DRES, PeerView, prepare_view, ransac
from ros_rops.bench.run_folder import Run
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.types import Floats
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

# Pairs that fit less are not even offered to the graph.
LEAST_FITNESS = 0.1


def refined(source: PeerView, target: PeerView, dres: float) -> Any:
    """Register a pair by RANSAC and two rounds of point-to-plane ICP."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    result = ransac(source, target, dres)
    for distance in ICP_DRES:
        result = registration.registration_icp(
            source.points, target.points, distance * dres, result.transformation,
            registration.TransformationEstimationPointToPlane())
    return result


def start_poses(count: int, fits: Mapping[tuple[int, int], tuple[float, Floats]]) -> list[Floats]:
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


def optimized(
    views: Sequence[PeerView], fits: Mapping[tuple[int, int], tuple[float, Floats]], dres: float
) -> list[Floats]:
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


def run_multiway(dataset: ReferenceSet, tell: Callable[[str], None]) -> dict[str, Any]:
    """Register all views of one data set; returns the keys of a multiview case."""
    import open3d as o3d

    start, start_cpu = time.perf_counter(), time.process_time()
    views = []
    for view in dataset.views.values():
        prepared = prepare_view(view, dataset.dres)
        prepared.points.estimate_normals(
            o3d.geometry.KDTreeSearchParamHybrid(NORMAL_DRES * dataset.dres, 30))
        views.append(prepared)
    fits = {}
    pairs = list(combinations(range(len(views)), 2))
    for number, (i, j) in enumerate(pairs):
        tell(f'open3d multiway: pair {number + 1} of {len(pairs)}')
        result = refined(views[i], views[j], dataset.dres)
        if result.fitness >= LEAST_FITNESS:
            fits[i, j] = (float(result.fitness), np.array(result.transformation))
    poses = optimized(views, fits, dataset.dres)
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    names = [f'{dataset.name}/{name}' for name in dataset.views]
    placements = {n: Placement('0', T) for n, T in zip(names, poses, strict=True)}
    run = Run(
        dataset.units, dataset.dres, placements, dict.fromkeys(names, 'placed'), {}, len(pairs))
    return {
        'case': 'multiview', 'by': 'open3d multiway', 'datasets': [dataset.name],
        'order': 'open3d', **evaluate(run, known_views([dataset])).numbers(),
        'seconds': seconds, 'cpu_seconds': cpu, 'peak_rss_mib': None,
    }
