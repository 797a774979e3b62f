# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a registration of two surfaces: matches, evidence, search, verdict; CCV, ICP."""

from dataclasses import dataclass

from ros_rops.core.errors import ParameterError
from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class MatchingConfig(Group):
    """Feature matching (III-B)."""

    neighbours: int = param(
        3, 'Nearest features taken for each feature (the paper: 1).', low=1, high=100)
    both_directions: bool = param(
        True, 'Match the target to the source too (the paper: no).')
    most: int = param(
        20000, 'Most matches of two sides.', low=10, high=10000000)


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
    hypotheses: str = param(
        'matches', 'The pose of every match as it is (matches), or as fitted to the group of '
        'matches consistent with it (ccv).', choices=('matches', 'ccv'))
    half_turns: bool = param(
        True, 'Each match also proposes its pose turned by 180 degrees about the normal: at the '
        'rim of what a view saw, a frame leans to the side seen (the paper: no).')
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
    area_mr2: float = param(
        700.0, 'Below this area of overlap the least score rises as the area falls: less than '
        'the support of a feature of 15 mr is little evidence.', unit='mr^2', low=0.0, high=1e9)
    score_sure: float = param(
        0.15, 'A score beyond doubt, which ends the search. Twice as much is plain: the nearest '
        'matches suffice, and while views of several objects arrive nothing else is believed.',
        low=0.0, high=1.0)
    residual_mr: float = param(
        0.35, 'Most mean distance point to plane of matched points, more where the views are '
        'noisy (noise_factor).', unit='mr', low=0.01, high=2.0)
    misfit: float = param(
        2.0, 'After fine registration a view is taken back whose residual exceeds this multiple '
        'of the most that a pair may have.', low=1.0, high=100.0)
    outlier: float = param(
        1.9, 'A pose is not believed while its residual exceeds this multiple of the median of '
        'those by which the two shapes grew.', low=1.0, high=100.0)
    conflict: float = param(
        2.0, 'After fine registration an object is taken apart where two of its views overlap '
        'and fit worse than this multiple of its median, and worse than a pair may.',
        low=1.0, high=100.0)
    noise_factor: float = param(
        0.8, "Residual allowed as a multiple of the views' own noise.", low=0.0, high=10.0)
    contradiction: float = param(
        0.25, 'Most that may contradict, as a share of the matched points: what stands in front '
        'of what the other side saw, and what that should have seen, weighted as in the score.',
        low=0.0, high=100.0)
    rival: float = param(
        0.6, 'Ambiguous if another pose scores more than this share of the best.',
        low=0.0, high=1.0)
    stiffness: float = param(
        0.002, 'Ambiguous if a motion of unit mean size changes the mean squared distance by '
        'less: the surface slides on itself.', low=0.0, high=1.0)
    overlap_least: float = param(
        0.5, "Share of the source's vertices on the target that must be exceeded "
        "(pairwise.method 'paper' only).", low=0.0, high=1.0)


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
    verified: int = param(
        2000, 'Most groups whose inliers are counted, those with the most members '
        "(pairwise.method 'paper').", low=1, high=1000000)


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
