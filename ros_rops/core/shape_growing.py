# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes that grow by registered views (Guo et al. 2014, IV-A)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.matching import match, match_transforms
from ros_rops.core.search import best_apart, refined_again
from ros_rops.core.surface import grow_surface, Surface
from ros_rops.core.types import Features, Floats


@dataclass(frozen=True, slots=True)
class Shape:
    """
    Views that are registered to each other; at first one alone.

    Parameters
    ----------
    surface : Surface
        Of all members, in the shape's frame.
    members : mapping of str to (4, 4) float64
        `T_shape_view` by the view's name, in order of joining.
    """

    surface: Surface
    members: Mapping[str, Floats]

    @property
    def size(self) -> int:
        """Return the number of views."""
        return len(self.members)

    @property
    def first(self) -> str:
        """Return the view in whose frame the shape is."""
        return next(iter(self.members))


def seed_shape(surface: Surface) -> Shape:
    """Start a shape from one view; its frame is the view's."""
    return Shape(surface, {surface.name: np.eye(4)})


def grow(
    shape: Shape, other: Shape, T_shape_other: Floats, config: Config, *, threads: int = 0
) -> Shape:
    """
    Join two shapes, one of which may be a single view.

    Parameters
    ----------
    shape : Shape
        Its frame stays.
    other : Shape
    T_shape_other : (4, 4) float64
    config : Config

    Returns
    -------
    Shape
    """
    moved = {name: T_shape_other @ pose for name, pose in other.members.items()}
    surface = grow_surface(
        shape.surface, other.surface, T_shape_other, config, threads=threads)
    return Shape(surface, {**shape.members, **moved})


def regrow(
    surfaces: Mapping[str, Surface],
    poses: Mapping[str, Floats],
    config: Config,
    *,
    threads: int = 0,
) -> Shape:
    """
    Grow a shape anew from its views at given poses (views taken back, poses refined).

    Parameters
    ----------
    surfaces : mapping of str to Surface
        Of the single views, by name.
    poses : mapping of str to (4, 4) float64
        `T_shape_view`; the first view's frame becomes the shape's.
    config : Config
    """
    names: Iterable[str] = iter(poses)
    first = next(iter(names))
    to_first = np.linalg.inv(poses[first])
    shape = seed_shape(surfaces[first])
    for name in list(poses)[1:]:
        shape = grow(
            shape, seed_shape(surfaces[name]), to_first @ poses[name], config,
            threads=threads)
    return shape


@dataclass(frozen=True, slots=True)
class Prospect:
    """
    What the nearest features of two surfaces say of them, as they are.

    Parameters
    ----------
    plausibility : float
        The best score that the pose of a match reaches; about 0 for surfaces of different
        objects, -1 without features.
    poses : (P, 4, 4) float64
        `T_target_source`; the best of those that differ, best first.
    """

    plausibility: float
    poses: Floats


def prospect(
    source: Surface,
    target: Surface,
    config: Config,
    *,
    careful: bool = False,
    threads: int = 0,
) -> Prospect:
    """
    Tell how likely two surfaces overlap, at a small part of the cost of a registration.

    Parameters
    ----------
    source, target : Surface
        At most `growth.votes` features of `source` are matched.
    config : Config
        At most `pairwise.quick` poses are kept.
    careful : bool
        Match all features of both sides instead.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Prospect
    """
    voters = source.features if careful else _every(source.features, config.growth.votes)
    nearest = replace(config.matching, neighbours=1, both_directions=careful)
    matches = match(voters, target.features, nearest, threads=threads)
    poses = match_transforms(voters, target.features, matches)
    if not len(poses):
        return Prospect(-1.0, poses)
    kept, score = best_apart(
        source, target, poses, max(config.pairwise.quick, 1), config.pairwise, threads=threads)
    return Prospect(score, kept)


def promise(
    source: Surface, target: Surface, poses: Floats, config: Config, *, threads: int = 0
) -> float:
    """
    Tell how well two surfaces fit where their features put them, once refined.

    It takes as long as the prospect and a part of a registration in vain, but tells objects of
    like local shape apart: unrefined poses of smooth surfaces all score.

    Parameters
    ----------
    source, target : Surface
    poses : (P, 4, 4) float64
        `T_target_source`, of their prospect.
    config : Config
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    float
        The best score that a verdict would rest on; -1 without poses.
    """
    if not len(poses):
        return -1.0
    found = refined_again(source, target, poses, config.pairwise, threads=threads)
    return float(found.scores[0])


def _every(features: Features, most: int) -> Features:
    """Take at most `most` features, spread over all."""
    step = -(-len(features.indices) // most)
    if step <= 1:
        return features
    return Features(
        features.indices[::step], features.positions[::step], features.lrfs[::step],
        features.descriptors[::step])
