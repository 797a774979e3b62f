# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Metres or millimetres, stated or inferred from the extent."""

import numpy as np

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Floats, RangeView, Units

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


def convert(view: RangeView, units: Units) -> RangeView:
    """
    Return a view with its lengths in other units, so that views of both kinds can be mixed.

    Parameters
    ----------
    view : RangeView
    units : {'m', 'mm'}

    Raises
    ------
    ParameterError
        If the view's own units, or those asked for, are unknown.
    """
    if 'unknown' in (view.units, units):
        raise ParameterError(f'units: cannot convert {view.name!r} from {view.units} to {units}')
    if view.units == units:
        return view
    return view.scaled(1000.0 if units == 'mm' else 0.001, units)
