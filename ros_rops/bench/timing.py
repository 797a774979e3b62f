# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Times of repeated runs, held against what they must and what they aim at."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ros_rops.bench.table import table

HEADS = ('what', 'data', 'runs', 'median ms', 'p90 ms', 'must ms', 'aim ms', 'reached')


@dataclass(frozen=True, slots=True)
class Limit:
    """The most milliseconds that a median may take; None where nothing is asked."""

    must_ms: float | None = None
    aim_ms: float | None = None


@dataclass(frozen=True, slots=True)
class Timing:
    """
    One thing measured.

    Parameters
    ----------
    what : str
    data : str
        What it was measured on.
    seconds : tuple of float
        Of each run; at least one.
    limit : Limit
    """

    what: str
    data: str
    seconds: tuple[float, ...]
    limit: Limit = Limit()

    @property
    def median_ms(self) -> float:
        """Return the median of the runs."""
        return 1000.0 * float(np.median(self.seconds))

    @property
    def reached(self) -> str | None:
        """Return 'aim', 'must' or 'neither' by the median; None where nothing is asked."""
        if self.limit.must_ms is None or self.limit.aim_ms is None:
            return None
        if self.median_ms <= self.limit.aim_ms:
            return 'aim'
        return 'must' if self.median_ms <= self.limit.must_ms else 'neither'

    def to_json(self) -> dict[str, Any]:
        """Return the entry of a benchmark's JSON."""
        return {
            'what': self.what, 'data': self.data, 'runs': len(self.seconds),
            'median_ms': self.median_ms, 'p90_ms': self._p90_ms(),
            'must_ms': self.limit.must_ms, 'aim_ms': self.limit.aim_ms, 'reached': self.reached}

    def row(self) -> list[object]:
        """Return the cells under `HEADS`."""
        return [
            self.what, self.data, len(self.seconds), self.median_ms, self._p90_ms(),
            self.limit.must_ms, self.limit.aim_ms, self.reached]

    def _p90_ms(self) -> float:
        return 1000.0 * float(np.quantile(self.seconds, 0.9))


def timing_table(timings: Sequence[Timing]) -> str:
    """Return a Markdown table, a line a timing."""
    rows = [
        [f'{cell:.1f}' if isinstance(cell, float) else cell for cell in timing.row()]
        for timing in timings]
    return table(HEADS, rows)
