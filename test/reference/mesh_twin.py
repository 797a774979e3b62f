# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The mesh kernel in NumPy: which candidate triangles lie on one surface, and what follows."""

from collections import Counter

import numpy as np


def surface(points, rays, candidates, edge_factor, least_cosine):
    """Return (faces, normals, boundary, resolution) of `mesh_from_triangles`."""
    spacing = expected_spacing(points, rays, candidates)
    kept = []
    for face in candidates.tolist():
        a, b, c = points[face]
        longest = max(np.linalg.norm(b - a), np.linalg.norm(c - b), np.linalg.norm(a - c))
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal)
        if longest > edge_factor * spacing[face].mean() or area <= 1e-6 * longest**2:
            continue
        cosine = normal @ rays[face[0]] / area
        if abs(cosine) >= least_cosine:
            kept.append(face if cosine >= 0 else [face[0], face[2], face[1]])
    faces = np.array(kept, np.int32).reshape(-1, 3)
    edges = edge_counts(faces)
    boundary = np.ones(len(points), bool)
    boundary[faces] = False
    for edge, count in edges.items():
        if count == 1:
            boundary[list(edge)] = True
    lengths = [np.linalg.norm(points[a] - points[b]) for a, b in edges]
    return faces, vertex_normals(points, faces), boundary, np.mean(lengths) if lengths else 0.0


def edge_counts(faces):
    """Count the faces of each edge (low, high)."""
    return Counter(
        tuple(sorted((face[k], face[(k + 1) % 3]))) for face in faces.tolist() for k in range(3))


def expected_spacing(points, rays, faces):
    """Return the lower median of the lateral lengths of each vertex's edges."""
    lengths = [[] for _ in points]
    for low, high in edge_counts(faces):
        lateral = np.linalg.norm(np.cross(points[high] - points[low], rays[low]))
        lengths[low].append(lateral)
        lengths[high].append(lateral)
    return np.array([sorted(found)[(len(found) - 1) // 2] if found else 0 for found in lengths])


def vertex_normals(points, faces):
    """Sum the faces' area vectors at their vertices, to unit length."""
    normals = np.zeros_like(points)
    for face in faces:
        a, b, c = points[face]
        normals[face] += np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(size > 0, size, 1)
