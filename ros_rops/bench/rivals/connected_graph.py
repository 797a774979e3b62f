# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The connected graph of Mian et al. 2006: nodes ask all that is left, in turn.

The view with the largest surface area is the root. Every remaining view is registered to it; what
is accepted and passes the global verification joins the graph and leaves the search space. Then
the next node asks what remains, in the order in which nodes joined, until nothing is left.

Published for one object. Where views remain that no node takes, a new graph begins with the
largest of them: the generous reading for several objects.
"""

import numpy as np
from ros_rops.bench.multiview import Job
from ros_rops.bench.rivals.strategy import Strategy
from ros_rops.bench.rivals.view_graph import Book, GraphSession, Pairs, Part
from ros_rops.core.types import RangeMesh


def surface_area(mesh: RangeMesh) -> float:
    """Return the area of a mesh's triangles."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def connected_graphs(pairs: Pairs) -> list[Part]:
    """Grow one graph after another; returns those of two or more views."""
    left = list(range(len(pairs.views)))
    areas = [surface_area(view.mesh) for view in pairs.views]
    parts = []
    while left:
        root = max(left, key=lambda k: (areas[k], -k))
        left.remove(root)
        parts.append(_grown(pairs, root, left))
    return [part for part in parts if len(part) > 1]


def _grown(pairs: Pairs, root: int, left: list[int]) -> Part:
    """Grow a graph; what joins is taken out of `left`."""
    part: Part = {root: np.eye(4)}
    nodes = [root]
    for node in nodes:  # grows meanwhile
        for k in list(left):
            T_node_k = pairs.pose(k, node)
            if T_node_k is None:
                continue
            pose = part[node] @ T_node_k
            others = {name: T for name, T in part.items() if name != node}
            if pairs.agree(others, {k: pose}):
                part[k] = pose
                nodes.append(k)
                left.remove(k)
    return part


def open_connected_graph(job: Job, book: Book | None = None) -> GraphSession:
    """Return the session of a job."""
    return GraphSession(job, connected_graphs, book)


CONNECTED_GRAPH = Strategy(
    'connected graph', 'Mian, Bennamoun and Owens 2006 [11]', open_connected_graph)
