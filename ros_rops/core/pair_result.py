# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a pairwise registration, by either method, comes to."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ros_rops.core.types import Floats, Status

Lap = Callable[[str], None]
"""Called with the name of a stage when that has ended."""


@dataclass(frozen=True, slots=True)
class PairResult:
    """
    Outcome of one pairwise registration.

    Parameters
    ----------
    source, target : str
        Names of the sides.
    status : Status
        PLACED, AMBIGUOUS or REFUSED.
    T_target_source : (4, 4) float64 or None
        None unless placed.
    reason : str
        One sentence.
    numbers : mapping of str to float
        Counts of every stage and what the verdict rests on.
    """

    source: str
    target: str
    status: Status
    T_target_source: Floats | None
    reason: str
    numbers: Mapping[str, float]
