# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Geometry as the report carries it: quantised, in base64, one JSON document an object.

| what | how |
|---|---|
| position | 3 x uint16 in the box of the object: 1/65535 of its longest edge |
| normal | 2 x uint8, octahedral (Cigolle et al. 2014); 255, 255 for none |
| colour | 3 x uint8 |
| view | uint16, place in the object's list of views; 65535 for none |
| residual | uint16 from -limit to limit, 65535 for none |
| state | uint8 |
| faces | 3 x 24 bits |

It is not deflated: browsers of before 2023 could not inflate it, and position and normal hardly
shrink.
"""

from base64 import b64encode
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, Floats32or64
from ros_rops.reporting.report_layers import Layer
from ros_rops.reporting.report_thin import spacing

NONE_16 = 65535
STEPS = 65534


def packed(layer: Layer, origin: Floats, edge: float, place: Mapping[int, int]) -> dict[str, Any]:
    """
    Return a layer as JSON holds it.

    Parameters
    ----------
    layer : Layer
    origin : (3,) float64
        Lowest corner of the object's box.
    edge : float
        Longest edge of that box.
    place : mapping of int to int
        `view_id` to the place in the object's list of views.
    """
    result: dict[str, Any] = {
        'count': len(layer.points), 'of': layer.of, 'spacing': _short(spacing(layer.points)),
        'position': _base64(np.rint((layer.points - origin) * (65535 / edge)), '<u2')}
    if layer.faces is not None:
        result |= {'triangles': len(layer.faces), 'of_triangles': layer.of_faces,
                   'faces': _faces(layer.faces), 'cell': _short(layer.cell)}
    if layer.normals is not None:
        result['normal'] = _base64(_octahedral(layer.normals), 'u1')
    if layer.colors is not None:
        result['rgb'] = _base64(layer.colors, 'u1')
    if layer.views is not None:
        ids, of = np.unique(layer.views, return_inverse=True)
        places = np.array([place.get(int(k), NONE_16) for k in ids])
        result['view'] = _base64(places[of], '<u2')
    if layer.residuals is not None:
        result |= _residuals(layer.residuals, layer.signed)
    if layer.states is not None:
        result['state'] = _base64(layer.states, 'u1')
    return result


def _residuals(values: NDArray[np.float32], signed: bool) -> dict[str, Any]:
    known = values[np.isfinite(values)].astype(np.float64)
    limit = float(np.abs(known).max(initial=0.0)) or 1.0
    steps = np.rint((values.astype(np.float64) / limit + 1.0) * (STEPS / 2))
    return {
        'residual': _base64(np.where(np.isfinite(steps), steps, NONE_16), '<u2'),
        'limit': _short(limit), 'signed': signed,
        'typical': _short(float(np.quantile(np.abs(known), 0.9)) if len(known) else 0.0)}


def _octahedral(normals: Floats32or64) -> Bytes:
    """Fold unit vectors onto a square: 0 to 254 in either direction, 255 for no normal."""
    normals = normals.astype(np.float64)
    size = np.abs(normals).sum(axis=1)
    some = np.isfinite(size) & (size > 0)
    x, y, z = (normals / np.where(some, size, 1.0)[:, None]).T
    folded_x = np.where(z >= 0, x, (1 - np.abs(y)) * np.where(x >= 0, 1, -1))
    folded_y = np.where(z >= 0, y, (1 - np.abs(x)) * np.where(y >= 0, 1, -1))
    square = np.rint((np.stack([folded_x, folded_y], axis=1) * 0.5 + 0.5) * 254)
    return np.where(some[:, None], square, 255).astype(np.uint8)


def _faces(faces: NDArray) -> str:
    """Return indices of 24 bits each, the lowest byte first."""
    wide = np.ascontiguousarray(faces, '<u4').reshape(-1).view(np.uint8).reshape(-1, 4)
    return _base64(wide[:, :3], 'u1')


def _base64(values: NDArray, dtype: str) -> str:
    return b64encode(np.ascontiguousarray(values.astype(dtype)).tobytes()).decode('ascii')


def _short(value: float) -> float:
    """Return a number with seven digits: more would only tell one libm from another."""
    return float(f'{value:.7g}')
