# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What every kernel asks of a mesh that it is handed."""

from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats, Ints


def check_mesh(vertices: Floats, faces: Ints) -> None:
    """
    Refuse what is no mesh: `vertices` must be (N, 3), `faces` (F, 3) numbers of these.

    Raises
    ------
    ShapeError
        If an array has the wrong shape, or a face names no vertex.
    """
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ShapeError(f'vertices: expected (N, 3), got {vertices.shape}')
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise ShapeError(f'faces: expected (F, 3), got {faces.shape}')
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise ShapeError(f'faces: expected numbers of the {len(vertices)} vertices')
