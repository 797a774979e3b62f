# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Nearest descriptors by every distance, in whole numbers as the kernel has them."""

import numpy as np

LONGEST = 30000.0


def quantised(a, b):
    """Return both sides as int64 and the size of one step."""
    longest = max(np.sqrt((side.astype(float) ** 2).sum(axis=1)).max() for side in (a, b))
    scale = LONGEST / longest if longest else 0.0
    # Halves away from zero, as C rounds.
    whole = [
        (np.sign(side) * np.floor(np.abs(side.astype(float) * scale) + 0.5)).astype(np.int64)
        for side in (a, b)]
    return *whole, 1.0 / scale if scale else 0.0


def squared_distances(a, b):
    """Return (Ka, Kb) int64, exact."""
    return ((a[:, None] - b[None]) ** 2).sum(axis=2)


def nearest(distance, k):
    """Return (Ka, k) columns, the nearest first, ties to the lower index."""
    return np.argsort(distance, axis=1, kind='stable')[:, :k]


def matches(a, b, neighbours, both, most):
    """Return [(source, target)] as `match` lists them, and their squared distances in steps."""
    distance = squared_distances(a, b)
    ranked = {}
    sides = [(distance, False), (distance.T, True)] if both else [(distance, False)]
    for table, turned in sides:
        for i, row in enumerate(nearest(table, neighbours)):
            for rank, j in enumerate(row):
                pair = (int(j), i) if turned else (i, int(j))
                ranked[pair] = min(rank, ranked.get(pair, rank))
    chosen = sorted(ranked, key=lambda pair: (ranked[pair], distance[pair], pair))[:most]
    chosen.sort(key=lambda pair: (distance[pair], pair))
    return chosen, np.array([distance[pair] for pair in chosen])
