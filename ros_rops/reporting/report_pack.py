# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Geometry as the report carries it: quantised, deflated, in base64, one JSON document an object.

| what | how |
|---|---|
| position | 3 x uint16 in the box of the object: 1/65535 of its longest edge; steps |
| normal | 2 x uint8, octahedral (Cigolle et al. 2014); 255, 255 for none; steps |
| colour | 3 x uint8; steps |
| view | uint16, place in the object's list of views; 65535 for none |
| residual | uint16, 0 to 8190, from -limit to limit; 65535 for none |
| state | uint8 |
| faces | zigzag uint32, three a triangle: steps of the first corner from that of the triangle \
before, of the others from the first; those that were filled come last |

Points and vertices follow Morton's curve, so that `steps` (differences from the one before,
modulo 2^16 or 2^8) are small; each byte of each column is a run of its own. So real scans need
less than half of the characters. `assets/unpack.js` undoes it.
"""

from base64 import b64encode
from collections.abc import Mapping
import math
from typing import Any
import zlib

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, Floats32or64
from ros_rops.reporting.report_layers import Layer
from ros_rops.reporting.report_thin import every_so_many, smallest_first, spacing

NONE_16 = 65535
STEPS = 8190
"""Of residuals, from -limit to limit: far finer than any sensor's noise."""
LEVEL = 5


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
    order = every_so_many(layer.points, len(layer.points))
    result: dict[str, Any] = {
        'count': len(layer.points), 'of': layer.of, 'spacing': _short(spacing(layer.points)),
        'position': _steps(
            np.rint((layer.points[order] - origin) * (65535 / edge)).astype('<u2'))}
    if layer.faces is not None:
        result |= _triangles(layer, order)
    if layer.normals is not None:
        result['normal'] = _steps(_octahedral(layer.normals[order]))
    if layer.colors is not None:
        result['rgb'] = _steps(layer.colors[order])
    if layer.views is not None:
        ids, of = np.unique(layer.views[order], return_inverse=True)
        places = np.array([place.get(int(k), NONE_16) for k in ids], '<u2')
        result['view'] = _deflated(places[of.reshape(-1)])
    if layer.residuals is not None:
        result |= _residuals(layer.residuals[order], layer.signed)
    if layer.states is not None:
        result['state'] = _deflated(layer.states[order])
    return result


def _residuals(values: NDArray[np.float32], signed: bool) -> dict[str, Any]:
    known = values[np.isfinite(values)].astype(np.float64)
    limit = float(np.abs(known).max(initial=0.0)) or 1.0
    steps = np.rint((values.astype(np.float64) / limit + 1.0) * (STEPS / 2))
    return {
        'residual': _deflated(np.where(np.isfinite(steps), steps, NONE_16).astype('<u2')),
        'limit': _short(limit), 'signed': signed}


def _triangles(layer: Layer, order: NDArray[np.int64]) -> dict[str, Any]:
    if layer.faces is None:
        return {}
    new = np.empty(len(order), np.int64)
    new[order] = np.arange(len(order))
    filled = np.zeros(len(layer.faces), np.bool_) if layer.filled is None else layer.filled
    faces = smallest_first(new[layer.faces])
    faces = faces[np.lexsort((faces[:, 2], faces[:, 1], faces[:, 0], filled))]
    steps = faces - faces[:, :1]
    steps[:, 0] = np.diff(faces[:, 0], prepend=0)
    zigzag = (steps << 1) ^ (steps >> 63)
    return {'triangles': len(faces), 'of_triangles': layer.of_faces, 'cell': _short(layer.cell),
            'filled': int(filled.sum()), 'faces': _deflated(zigzag.reshape(-1).astype('<u4'))}


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


def _steps(values: NDArray) -> str:
    """Return columns of unsigned numbers, each row less the one before."""
    steps = values.copy()
    steps[1:] -= values[:-1]
    return _deflated(steps)


def _deflated(values: NDArray) -> str:
    """Return the bytes of each column, the lowest of all rows first, deflated in base64."""
    width = values.itemsize * math.prod(values.shape[1:])
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), width).T
    deflate = zlib.compressobj(LEVEL, zlib.DEFLATED, -zlib.MAX_WBITS)
    data = deflate.compress(np.ascontiguousarray(planes).tobytes()) + deflate.flush()
    return b64encode(data).decode('ascii')


def _short(value: float) -> float:
    """Return a number with seven digits: more would only tell one libm from another."""
    return float(f'{value:.7g}')
