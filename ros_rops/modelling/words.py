# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Lengths and places in words: those in metres as millimetres, as the reports have them."""

import math

from ros_rops.core.types import Floats, Units


def length(value: float, units: Units) -> str:
    """Return a length with its unit."""
    return f'{value * _scale(units):.3g} {_name(units)}'


def place(point: Floats, size: float, units: Units) -> str:
    """Return a point (3,) with its unit, to a hundredth of the length `size`."""
    return f'{coordinates(point * _scale(units), size * _scale(units))} {_name(units)}'


def coordinates(vector: Floats, size: float = 1.0) -> str:
    """Return numbers (3,) to a hundredth of `size`."""
    digits = max(0, 2 - math.floor(math.log10(size))) if size > 0 else 2
    # No minus before a zero.
    rounded = [round(float(value), digits) + 0.0 for value in vector]
    return '(' + ', '.join(f'{value:.{digits}f}' for value in rounded) + ')'


def _scale(units: Units) -> float:
    return 1000.0 if units == 'm' else 1.0


def _name(units: Units) -> str:
    return 'units' if units == 'unknown' else 'mm'
