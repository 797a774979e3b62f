# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The motion of a view that the other views hold least, in words.

From the point-to-plane normal matrix of the view against the others, its turns scaled by the
view's size, so that every unit motion moves the view's points by about the same length and the
eigenvalues have no unit (Gelfand et al. 2003, Geometrically stable sampling, 3; the scaling is
that of `core.fine_system`). The eigenvalue is the mean squared change of distance for a motion
of unit size: near 0 the surface slides on itself, 1/3 is the mean over all motions of a ball's
worth of normals.
"""

from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from ros_rops.core.types import Floats, Units
from ros_rops.modelling.words import coordinates, length, place

# A part of a motion smaller than this share of it is not worth a word.
_PURE = 0.15
# Motions held at most so many times better than the least held one are as good as equal.
_ALIKE = 2.0


@dataclass(frozen=True, slots=True)
class Constraint:
    """
    The motion held least.

    Parameters
    ----------
    kind : {'translation', 'rotation', 'screw'}
    direction : (3,) tuple of float
        Of the translation, or of the axis; unit, in the object's frame.
    point : (3,) tuple of float or None
        Of the axis, nearest to the view's middle; None for a translation.
    stiffness : float
    held : bool
        Whether it reaches the least stiffness of the fine registration.
    text : str
        The motion in words, lengths with their unit.
    """

    kind: str
    direction: tuple[float, float, float]
    point: tuple[float, float, float] | None
    stiffness: float
    held: bool
    text: str

    def document(self) -> dict[str, Any]:
        """Return it in JSON's own types."""
        return {
            'kind': self.kind, 'direction': list(self.direction),
            'point': None if self.point is None else list(self.point),
            'stiffness': self.stiffness, 'held': self.held, 'text': self.text}


def least_constrained(
    values: Floats, motions: Floats, middle: Floats, size: float, least: float,
    units: Units = 'unknown',
) -> Constraint | None:
    """
    Name the motion that a view's neighbours hold least.

    Parameters
    ----------
    values : (6,) float64
        Stiffness of the motions, ascending.
    motions : (6, 6) float64
        Columns: rotation vector times `size`, translation, about `middle`.
    middle : (3,) float64
        Of the view, in the object's frame.
    size : float
        Root mean square distance of the view's points from it.
    least : float
        Below this stiffness a motion is not held.
    units : {'m', 'mm', 'unknown'}
        Of the lengths.

    Returns
    -------
    Constraint or None
        None if nothing is matched (all values 0).
    """
    if not values[-1] > 0.0:
        return None
    alike = values <= max(_ALIKE * values[0], 0.0 if values[0] >= least else least)
    motion = _purest(motions[:, alike])
    free = int(np.count_nonzero(values < least))
    grip = 'held' if values[0] >= least else 'hardly held'
    more = f', one of {free} motions that are not' if free > 1 else ''
    kind, direction, point, text = _worded(motion, middle, size, units)
    return Constraint(
        kind, _three(direction), None if point is None else _three(point), float(values[0]),
        bool(values[0] >= least), f'{text}: {values[0]:.2g}, {grip}{more}')


def _purest(motions: Floats) -> Floats:
    """Of the motions (6, K) held alike return a translation if there is one, else the first."""
    _, turning, mix = np.linalg.svd(motions[:3])
    slide = motions @ mix[-1]
    pure = motions.shape[1] > 3 or turning[-1] < _PURE
    chosen: Floats = slide if pure else motions[:, 0]
    return chosen


def _worded(
    motion: Floats, middle: Floats, size: float, units: Units
) -> tuple[str, Floats, Floats | None, str]:
    """Return kind, direction, a point of the axis, and the motion in words."""
    turn, shift = motion[:3], motion[3:]
    if np.linalg.norm(turn) < _PURE:
        direction = _oriented(shift)
        return 'translation', direction, None, f'slides along {coordinates(direction)}'
    direction = _oriented(turn)
    # The axis of the twist (omega, v at the middle): p = m + omega x v / |omega|^2.
    omega = turn / size
    point = middle + np.cross(omega, shift) / (omega @ omega)
    along = float(shift @ turn) / float(turn @ turn) * size
    away = float(np.linalg.norm(point - middle))
    # Where the axis passes by the middle at some distance, most of the motion looks like a shift.
    where = 'its middle' if away < _PURE * size else place(point, size, units)
    kind, way = 'rotation', 'turns'
    if abs(along) > _PURE * math.hypot(size, away):
        kind, way = 'screw', f'screws ({length(abs(along) * 2.0 * math.pi, units)} a turn)'
    return kind, direction, point, f'{way} about {coordinates(direction)} through {where}'


def _oriented(vector: Floats) -> Floats:
    """Return the direction, its largest component positive: both senses are meant."""
    unit: Floats = vector / np.linalg.norm(vector)
    return unit if unit[np.argmax(np.abs(unit))] > 0 else -unit


def _three(vector: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in vector)
    return x, y, z
