# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Metres or millimetres, stated or inferred from the extent."""

import numpy as np

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Floats, Units

LARGEST_M = 10.0
"""An object on a scanning station is smaller than this many metres: beyond, it is millimetres."""

CHOICES = ('auto', 'm', 'mm')


def resolve_units(points: Floats, stated: str) -> tuple[Units, str]:
    """
    Return the units of `points` (N, 3) and a note ('' if they were stated).

    Parameters
    ----------
    points : (N, 3) float64
        Finite.
    stated : {'auto', 'm', 'mm'}

    Raises
    ------
    ParameterError
        If `stated` is none of those.
    """
    if stated == 'm':
        return 'm', ''
    if stated == 'mm':
        return 'mm', ''
    if stated != 'auto':
        raise ParameterError(f'units: {stated!r} is none of {", ".join(CHOICES)}')
    if len(points) < 2:
        return 'unknown', 'units unknown: fewer than two points'
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    if diagonal == 0.0:
        return 'unknown', 'units unknown: all points coincide'
    units: Units = 'mm' if diagonal > LARGEST_M else 'm'
    return units, f'units inferred: {units} (the bounding box measures {diagonal:.3g} across)'
