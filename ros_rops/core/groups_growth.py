# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of growing and refining shapes."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


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
        3, 'Shapes that a view tries at most each time the shapes have changed, and an object at '
        'the end.', low=1, high=1000)
    better: float = param(
        1.1, 'Views that did not fit an object try it again when it has grown and their score is '
        'so many times higher.', low=1.0, high=1000.0)
    larger: float = param(
        1.25, 'Or when it has so many times as many views; all try again at the end.',
        low=1.0, high=1000.0)
    partners: int = param(
        8, 'Shapes that a shape considers with all its features at the end, and that a view tries '
        'thoroughly then.',
        low=1, high=1000000)
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
    partners: int = param(
        16, 'Views of an object that a view is matched with: up to so many others all of them; of '
        'more, about so many, those that it overlaps most and some of the rest.',
        low=4, high=100000)
    least_matches: int = param(
        30, 'Two views with fewer matches (both ways) do not hold each other.',
        low=6, high=100000)
    least_stiffness: float = param(
        0.003, 'A view keeps its pose along a motion (of unit mean size) that changes the mean '
        'squared distance to its neighbours by less than this.', low=0.0, high=1.0)
    tolerance_mr: float = param(
        0.01, 'Done when no view moves by more.', unit='mr', low=0.0, high=1.0)
