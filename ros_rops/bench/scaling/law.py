# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Power laws: the exponent by which a measured quantity grows."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np


@dataclass(frozen=True, slots=True)
class Law:
    """
    value = factor * size ** exponent, fitted.

    Parameters
    ----------
    exponent : float
    error : float
        Standard error of the exponent; NaN where two sizes leave nothing to tell it from.
    factor : float
    """

    exponent: float
    error: float
    factor: float

    def __str__(self) -> str:
        """Return the exponent and its error as they are printed."""
        error = '' if math.isnan(self.error) else f' +- {self.error:.2f}'
        return f'{self.exponent:.2f}{error}'


def fit_law(sizes: Sequence[float], values: Sequence[float | None]) -> Law | None:
    """
    Fit a power law by least squares between the logarithms.

    Parameters
    ----------
    sizes : sequence of float
        Positive.
    values : sequence of float or None
        One a size; what is not positive or not known does not count.

    Returns
    -------
    Law or None
        None with fewer than two different sizes.
    """
    known = [
        (math.log(size), math.log(value))
        for size, value in zip(sizes, values, strict=True) if value is not None and value > 0]
    if len({x for x, _ in known}) < 2:
        return None
    x, y = np.array(known).T
    across = x - x.mean()
    spread = float(across @ across)
    exponent = float(across @ y) / spread
    height = float(y.mean()) - exponent * float(x.mean())
    rest = y - height - exponent * x
    free = len(x) - 2
    error = math.sqrt(float(rest @ rest) / free / spread) if free else math.nan
    return Law(exponent, error, math.exp(height))
