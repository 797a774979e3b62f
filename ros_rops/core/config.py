# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Every parameter, once: default, bounds, unit and one sentence.

YAML, ROS declarations, `--help` and the README's table are derived from these dataclasses.
Lengths of the algorithm are in mesh resolutions (suffix `_mr`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace

from ros_rops.core.errors import ParameterError
from ros_rops.core.parameter import describe_group, Group, param, ParameterInfo, Scalar


@dataclass(frozen=True, slots=True)
class MeshConfig(Group):
    """Range view to mesh (III-A)."""

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


@dataclass(frozen=True, slots=True)
class MatchingConfig(Group):
    """Feature matching (III-B)."""

    neighbours: int = param(
        5, 'Nearest features taken for each feature (the paper: 1).', low=1, high=100)
    both_directions: bool = param(
        True, 'Match the target to the source too (the paper: no).')
    most: int = param(
        20000, 'Most matches of two sides.', low=10, high=10000000)


@dataclass(frozen=True, slots=True)
class CcvConfig(Group):
    """Consistent correspondences verification (III-C)."""

    metric: str = param(
        'so3', 'Transforms compared by angle of rotation and at the centre of the source (so3), '
        'or by Euler angles and raw translation vectors (euler, the paper).',
        choices=('so3', 'euler'))
    angle_rad: float = param(
        0.2, 'Consistent transforms differ by less in rotation.', unit='rad', low=0.001, high=3.0)
    distance_mr: float = param(
        10.0, 'Consistent transforms differ by less in translation.',
        unit='mr', low=0.1, high=1000.0)
    simplify_mr: float = param(
        3.0, 'Cell of the simplified surfaces whose inliers are counted.',
        unit='mr', low=0.5, high=20.0)
    inlier_mr: float = param(
        2.0, 'A point this near to the other surface is an inlier.',
        unit='mr', low=0.1, high=50.0)


@dataclass(frozen=True, slots=True)
class IcpConfig(Group):
    """Fine pairwise registration (III-D, eq. 8)."""

    method: str = param(
        'point_to_plane', 'Distance minimised: to the plane of the nearest point, or to the '
        'point itself (paper).', choices=('point_to_plane', 'paper'))
    reject_mr: float = param(
        2.0, 'Pairs farther apart are rejected.', unit='mr', low=0.1, high=100.0)
    n_min: int = param(
        500, 'Points sampled while the residual is a mesh resolution or more.',
        low=10, high=1000000)
    n_max: int = param(
        2000, 'Points sampled when the residual is e^-2 mesh resolutions or less.',
        low=10, high=1000000)
    iterations: int = param(50, 'Most iterations.', low=1, high=1000)
    tolerance_mr: float = param(
        0.002, 'Done when the sample moves by less (root mean square).',
        unit='mr', low=0.0, high=1.0)
    seed: int = param(0, 'Of the random samples.', low=0, high=2147483647)

    def __post_init__(self) -> None:
        """Check every value, and that the sample grows."""
        Group.__post_init__(self)
        if self.n_min > self.n_max:
            raise ParameterError(f'n_min: {self.n_min} is above n_max = {self.n_max}')


@dataclass(frozen=True, slots=True)
class EvidenceConfig(Group):
    """What a view testifies: closest-cell field and depth raster."""

    cell_mr: float = param(
        2.0, 'Edge of a cell of the closest-cell field and of a pixel of the depth raster.',
        unit='mr', low=0.5, high=20.0)
    reach_cells: int = param(
        7, 'Cells around a surface from which it is found.', unit='cells', low=1, high=30)
    grow_mr: float = param(
        1.0, 'Vertices farther than this from the shape are added to it (IV-A).',
        unit='mr', low=0.1, high=2.0)


@dataclass(frozen=True, slots=True)
class PairwiseConfig(Group):
    """Search for the pose between two surfaces (III-B to III-D)."""

    method: str = param(
        'verified', 'Score, refine and verify many hypotheses (verified), or the best group of '
        'consistent correspondences and its ICP (paper).', choices=('verified', 'paper'))
    matches: bool = param(True, 'Take hypotheses from matched features.')
    random_starts: int = param(
        10000, 'Hypotheses from random pairings of local frames, where the matches alone do '
        'not suffice.', low=0, high=1000000)
    quick: int = param(
        20, 'Hypotheses refined before the thorough search, which is spared if one of them is '
        'beyond doubt.', low=0, high=100000)
    refined: int = param(1000, 'Most hypotheses refined.', low=1, high=100000)
    seed: int = param(0, 'Seed of the random pairings.', low=0, high=2**31 - 1)
    tau_mr: float = param(
        6.0, 'Distance at which a point no longer counts for a hypothesis.',
        unit='mr', low=1.0, high=14.0)
    front_mr: float = param(
        8.0, 'Depth in front of what the other sensor saw that contradicts a hypothesis.',
        unit='mr', low=1.0, high=50.0)
    samples_first: int = param(
        30, 'Points of each side that score every hypothesis.', low=10, high=100000)
    samples_coarse: int = param(
        100, 'Points of each side that score the better part of them.', low=10, high=100000)
    samples_fine: int = param(
        300, 'Points of each side that score the best of those.', low=10, high=100000)
    samples_refine: int = param(
        200, 'Points of each side in a round of refinement.', low=10, high=100000)
    rounds: int = param(12, 'Rounds of refinement.', low=1, high=100)
    radius_start_mr: float = param(
        10.0, 'Distance of matched points in the first round.', unit='mr', low=1.0, high=14.0)
    radius_end_mr: float = param(
        3.0, 'Distance of matched points in the last round.', unit='mr', low=0.5, high=14.0)


@dataclass(frozen=True, slots=True)
class VerdictConfig(Group):
    """When a pose is believed, doubted or refused."""

    score_least: float = param(
        0.05, 'Least score: overlap less what contradicts it.', low=0.0, high=1.0)
    score_sure: float = param(
        0.15, 'A score beyond doubt, which ends the search.', low=0.0, high=1.0)
    residual_mr: float = param(
        0.35, 'Most mean distance point to plane of matched points, more where the views are '
        'noisy (noise_factor).', unit='mr', low=0.01, high=2.0)
    noise_factor: float = param(
        1.5, "Residual allowed as a multiple of the views' own noise.", low=0.0, high=10.0)
    rival: float = param(
        0.6, 'Ambiguous if another pose scores more than this share of the best.',
        low=0.0, high=1.0)
    stiffness: float = param(
        0.002, 'Ambiguous if a motion of unit mean size changes the mean squared distance by '
        'less: the surface slides on itself.', low=0.0, high=1.0)


@dataclass(frozen=True, slots=True)
class GrowthConfig(Group):
    """Shape growing over mixed views of several objects (IV-A)."""

    plausible: float = param(
        0.1, 'A view tries a shape at once if its matched features reach this score; else it '
        'waits until no better chance is left.', low=0.0, high=1.0)
    least: float = param(
        0.03, 'Below this score of its matched features a view does not try a shape at all.',
        low=-1.0, high=1.0)
    votes: int = param(
        600, 'Features of a view that tell which shapes are plausible.', low=10, high=1000000)
    tries: int = param(
        3, 'Shapes that a view tries at most each time the shapes have changed.',
        low=1, high=1000)
    resolution_ratio: float = param(
        3.0, 'A view whose mesh resolution differs from the first by more is refused: its units '
        'are probably others.', low=1.0, high=1000.0)


@dataclass(frozen=True, slots=True)
class FineConfig(Group):
    """Multi-view fine registration (IV-B)."""

    method: str = param(
        'simultaneous', 'All views together, point to plane (simultaneous), or corresponding '
        'point sets, point to point (williams, the paper).', choices=('simultaneous', 'williams'))
    iterations: int = param(40, 'Most rounds.', low=0, high=1000)
    radius_start_mr: float = param(
        3.0, 'Distance of two matched points at most, in the first round.',
        unit='mr', low=0.5, high=50.0)
    radius_mr: float = param(
        1.0, 'The same in the last round; more where the data are noisier (noise_factor).',
        unit='mr', low=0.2, high=50.0)
    noise_factor: float = param(
        5.0, 'The radius never falls below this multiple of the mean residual.',
        low=0.0, high=50.0)
    normal_support_mr: float = param(
        3.0, 'Radius of the neighbourhood whose plane gives a normal.',
        unit='mr', low=1.5, high=20.0)
    normal_angle_deg: float = param(
        45.0, 'Points match only if their normals differ by less.',
        unit='deg', low=5.0, high=180.0)
    samples: int = param(
        1200, 'Points sampled of each view until the poses settle.', low=50, high=1000000)
    samples_last: int = param(
        4000, 'Points sampled of each view in the last rounds.', low=50, high=1000000)
    least_matches: int = param(
        30, 'Two views with fewer matches (both ways) do not hold each other.',
        low=6, high=100000)
    least_stiffness: float = param(
        0.003, 'A view keeps its pose along a motion (of unit mean size) that changes the mean '
        'squared distance to its neighbours by less than this.', low=0.0, high=1.0)
    tolerance_mr: float = param(
        0.01, 'Done when no view moves by more.', unit='mr', low=0.0, high=1.0)


@dataclass(frozen=True, slots=True)
class Config:
    """All parameters of the engine, by group."""

    mesh: MeshConfig = MeshConfig()
    keypoints: KeypointConfig = KeypointConfig()
    lrf: LrfConfig = LrfConfig()
    rops: RopsConfig = RopsConfig()
    matching: MatchingConfig = MatchingConfig()
    ccv: CcvConfig = CcvConfig()
    icp: IcpConfig = IcpConfig()
    evidence: EvidenceConfig = EvidenceConfig()
    pairwise: PairwiseConfig = PairwiseConfig()
    verdict: VerdictConfig = VerdictConfig()
    growth: GrowthConfig = GrowthConfig()
    fine: FineConfig = FineConfig()

    @classmethod
    def from_flat(cls, values: Mapping[str, object]) -> 'Config':
        """
        Make a configuration from dotted names, the rest at their defaults.

        Parameters
        ----------
        values : mapping
            For example ``{'rops.radius_mr': 12.0}``.

        Raises
        ------
        ParameterError
            For an unknown name, a wrong type or a value out of bounds.
        """
        known = {info.name for info in describe()}
        groups: dict[str, dict[str, object]] = {}
        for name, value in values.items():
            if name not in known:
                raise ParameterError(f'{name}: no such parameter')
            group, _, leaf = name.partition('.')
            groups.setdefault(group, {})[leaf] = value
        config = cls()
        for group, items in groups.items():
            try:
                part = replace(getattr(config, group), **items)
            except ParameterError as error:
                raise ParameterError(f'{group}.{error}') from None
            config = replace(config, **{group: part})
        return config

    def to_flat(self) -> dict[str, Scalar]:
        """Return all values by dotted name, in the order of declaration."""
        return {
            f'{group.name}.{item.name}': getattr(getattr(self, group.name), item.name)
            for group in fields(self)
            for item in fields(getattr(self, group.name))
        }


def describe() -> Iterator[ParameterInfo]:
    """Yield every parameter by dotted name, in the order of declaration."""
    for group in fields(Config):
        yield from describe_group(type(group.default), group.name + '.')
