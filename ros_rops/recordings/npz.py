# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""NumPy archives: `points` (N, 3) or (H, W, 3), optionally `colors` and `grid`."""

import io
import zipfile
import zlib

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings.cloud import Cloud, FormatError, full_grid, to_bytes


def parse(data: bytes) -> Cloud:
    """
    Return the cloud of an NPZ file; nothing pickled is ever loaded.

    Raises
    ------
    FormatError
        If the bytes are no NPZ file, are damaged, or an array is missing or of a wrong shape.
    """
    if not data.startswith(b'PK\x03\x04'):
        raise FormatError('is not an NPZ file')
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {k: archive[k] for k in ('points', 'colors', 'grid') if k in archive}
    except (ValueError, OSError, EOFError, KeyError, SyntaxError, MemoryError,
            NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise FormatError(f'is not a sound NPZ file ({error})') from None
    if 'points' not in arrays:
        raise FormatError('has no array "points"')
    points = arrays['points']
    if points.ndim not in (2, 3) or points.shape[-1] != 3 or points.dtype.kind not in 'fiu':
        raise FormatError(f'its points are {points.dtype} {points.shape}, not (N, 3) or (H, W, 3)')
    colors = arrays.get('colors')
    if colors is not None and (colors.shape != points.shape or colors.dtype.kind not in 'fiu'):
        raise FormatError(f'its colors {colors.shape} do not go with its points {points.shape}')
    return Cloud(
        np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3),
        _grid(points, arrays.get('grid')),
        None if colors is None else to_bytes(colors.reshape(-1, 3)),
    )


def _grid(points: NDArray, grid: NDArray | None) -> NDArray[np.int32] | None:
    if points.ndim == 3:
        return full_grid(*points.shape[:2])
    if grid is None:
        return None
    if grid.ndim != 2 or grid.dtype.kind not in 'iu':
        raise FormatError(f'its grid is {grid.dtype} {grid.shape}, not (H, W) integers')
    if grid.size and (int(grid.max()) >= len(points) or int(grid.min()) < -1):
        raise FormatError('its grid names a point which does not exist')
    return grid.astype(np.int32)
