# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of what describes a view: mesh, feature points, frames, descriptors."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class MeshConfig(Group):
    """Range view to mesh (III-A)."""

    depth_steps: float = param(
        1.5, 'Sample an organized view no finer than so many of the steps in which its depths '
        'come (1 mm for many depth cameras); 0 takes every pixel.',
        unit='steps', low=0.0, high=20.0)
    noise_least: float = param(
        0.3, 'Even out the noise of a view that has at least so much, in spacings of its points; '
        '0 leaves views alone.', unit='spacings', low=0.0, high=100.0)
    edge_factor: float = param(
        4.0, 'Drop a triangle whose longest edge exceeds this multiple of the edge length '
        'expected at its place.', low=1.5, high=20.0)
    grazing_deg: float = param(
        80.0, 'Drop a triangle seen at more than this angle from its normal.',
        unit='deg', low=45.0, high=90.0)


@dataclass(frozen=True, slots=True)
class KeypointConfig(Group):
    """Feature points (III-A)."""

    method: str = param(
        'uniform', 'Choose among all vertices (uniform) or among those nearest to a simplified '
        'mesh (paper).', choices=('uniform', 'paper'))
    cluster_mr: float = param(
        2.0, "Cell of the simplified mesh (method 'paper').", unit='mr', low=0.5, high=20.0)
    spacing_mr: float = param(
        3.0, 'Minimum distance between two keypoints.', unit='mr', low=0.5, high=50.0)
    boundary_mr: float = param(
        1.0, 'Keypoints keep this distance from the boundary of the mesh.',
        unit='mr', low=0.0, high=50.0)
    eigen_ratio: float = param(
        1.0, 'Keep a keypoint only where lambda1/lambda2 of its support exceeds this '
        '(the paper: 1.02; 1 keeps all).', low=1.0, high=10.0)
    most: int = param(2000, 'Most keypoints of a view.', low=10, high=100000)


@dataclass(frozen=True, slots=True)
class LrfConfig(Group):
    """Local reference frame (Guo et al., IJCV 2013)."""

    method: str = param(
        'toldi', 'Frame: covariance of the support (rops, the paper) or normal of a smaller '
        'support with x by weighted projection (toldi).', choices=('rops', 'toldi'))
    triangles: str = param(
        'author', 'Which triangles count: all vertices and the centroid within the radius '
        '(author) or any vertex (pcl).', choices=('author', 'pcl'))
    normal_radius_mr: float = param(
        5.0, 'Radius of the normal for the toldi frame.', unit='mr', low=1.0, high=50.0)


@dataclass(frozen=True, slots=True)
class RopsConfig(Group):
    """RoPS descriptor (III-A, eqs. 1-4)."""

    radius_mr: float = param(
        10.0, 'Radius of the support of a feature.', unit='mr', low=2.0, high=100.0)
    rotations: int = param(3, 'Rotations about each axis (T).', low=1, high=12)
    bins: int = param(5, 'Bins of a side of the distribution matrix (L).', low=2, high=16)
    convention: str = param(
        'author', 'Angles, axis order and normalisation of the toolbox followed.',
        choices=('author', 'pcl'))
    loose_vertices: bool = param(
        False, 'Vertices without a face (stray points) belong to supports too, as in both '
        'toolboxes.')
