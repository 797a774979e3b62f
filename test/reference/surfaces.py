# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Analytic surfaces for tests of meshes and features."""

import numpy as np
from ros_rops.core.config import MeshConfig
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import RangeMesh, RangeView, SensorModel

DOWN = SensorModel('orthographic', direction=(0.0, 0.0, -1.0))


def height_view(height, shape=(20, 20), grid=True, jitter=0.0):
    """Return the view from above of z = height(x, y) on a unit lattice, shaken by `jitter`."""
    y, x = np.mgrid[0:shape[0], 0:shape[1]].astype(float)
    shake = np.random.default_rng(5).uniform(-jitter, jitter, (2, *shape))
    x, y = x + shake[0], y + shake[1]
    points = np.stack([x, y, height(x, y) + 0 * x], axis=-1).reshape(-1, 3)
    pixels = np.arange(len(points), dtype=np.int32).reshape(shape)
    return RangeView('field', points, pixels if grid else None, DOWN)


def bumps(x, y):
    """Height without any symmetry."""
    return 2.5 * np.sin(x / 4.1) + 1.7 * np.cos(y / 2.9 + x / 9) + 0.02 * (x - 11) * (y - 17)


def bumpy_mesh(shape=(45, 48)):
    """Mesh of `bumps`: about 2000 vertices, no two supports alike."""
    return build_mesh(height_view(bumps, shape, jitter=0.2), MeshConfig())


def moved(mesh, rotation, translation, scale=1.0):
    """Return the mesh rotated, scaled and translated."""
    return RangeMesh(
        mesh.vertices @ rotation.T * scale + translation, mesh.faces,
        mesh.normals @ rotation.T, mesh.boundary, mesh.resolution * scale)
