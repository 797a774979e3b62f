# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Views in the session's units."""

from dataclasses import replace

from ros_rops.core.types import RangeView, Units

_METRES = {'m': 1.0, 'mm': 1e-3}


def in_units(view: RangeView, units: Units) -> RangeView:
    """
    Return `view` in `units`.

    A view of unknown units is taken to be in those of the session.
    """
    if view.units == units or units == 'unknown':
        return view
    if view.units == 'unknown':
        return replace(view, units=units)
    return view.scaled(_METRES[view.units] / _METRES[units], units)
