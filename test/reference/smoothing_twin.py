# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""NumPy twin of the kernel that evens out noise: the same by plain least squares."""

import numpy as np


def _plane(du, dv, weights, values):
    """Value and slopes of a plane by weighted least squares, None where it has none."""
    if len(du) < 6:
        return None
    terms = np.stack([np.ones_like(du), du, dv], axis=1)
    moments = terms.T @ (weights[:, None] * terms)
    if not np.linalg.det(moments) > 1e-3 * moments[0, 0]**3:
        return None
    return np.linalg.solve(moments, terms.T @ (weights * values))


def smooth_twin(places, values, sigma, noise):
    """Return the values (N, C) of planes fitted around places (N, 2)."""
    result = values.copy()
    for i in range(len(places)):
        du, dv = (places - places[i]).T
        square = du**2 + dv**2
        step = np.abs(values[:, -1] - values[i, -1])
        near = (square <= 4.0 * sigma**2) & (
            step <= 3.0 * np.sqrt(square) + 3.0 * np.sqrt(2.0) * noise + 0.5)
        weights = np.exp(-0.5 * square / sigma**2)
        plane = _plane(du[near], dv[near], weights[near], values[near, -1])
        if plane is None:
            continue
        off = np.abs(values[:, -1] - plane[0] - plane[1] * du - plane[2] * dv)
        near &= off <= 3.0 * noise * np.sqrt(1.0 + plane[1]**2 + plane[2]**2) + 0.5
        if not near[i]:
            continue
        for column in range(values.shape[1]):
            plane = _plane(du[near], dv[near], weights[near], values[near, column])
            if plane is not None:
                result[i, column] = plane[0]
    return result
