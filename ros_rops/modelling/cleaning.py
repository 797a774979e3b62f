# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A surface made presentable: manifold, turned outwards, without floating pieces; its facts."""

import numpy as np
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bools, Floats, frozen, Ints
from ros_rops.modelling.floating import sound_pieces, turned_outwards
from ros_rops.modelling.products import Fact, SurfaceMesh
from ros_rops.modelling.sewing import sewn, true_faces
from ros_rops.modelling.topology import (
    areas, border_loops, compacted, ends, face_components, fans, grouped_sides, Longs,
    simple_mates, six_volumes, vertex_normals)


def cleaned(mesh: SurfaceMesh, *, resolution: float) -> SurfaceMesh:
    """
    Make a surface manifold and turn it outwards; take floating pieces away.

    Faces without extent and faces twice go; neighbours are made to turn the same way; edges of
    more than two faces and vertices in which only points touch are taken apart. A closed piece
    is turned so that it has a positive volume, an open one so that it agrees with the normals
    handed in, which point towards the sensors. Pieces go that no line of sight can have reached
    (in the inside of a closed one), and such as lie nowhere `modelling.weights.RAMP_MR` away
    from their own border: no point of them ever had its full weight.

    Parameters
    ----------
    mesh : SurfaceMesh
        Any faces whatever; zero normals where nothing is known.
    resolution : float
        What mr means, in the units of the vertices.

    Returns
    -------
    SurfaceMesh
        With the facts of `mesh_facts`, and `floating_removed`, `floating_share` (of the area),
        `hidden_removed`, `crowded_edges`, `split_vertices` and `filled_share` (of the area),
        beside those handed in.

    Raises
    ------
    ShapeError
        If an index lies outside the vertices, or something is not finite.
    """
    _check(mesh, resolution)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    faces, origins = true_faces(vertices, mesh.faces)
    whole = sewn(vertices, faces)
    normals = np.asarray(mesh.normals, dtype=np.float64)[whole.sources]
    faces, mates, hidden = turned_outwards(whole.vertices, whole.faces, whole.mates, normals)
    kept, counts = sound_pieces(whole.vertices, faces, mates, hidden, resolution)
    faces, left = compacted(faces[kept], len(whole.vertices))
    mates = _kept_mates(mates, kept)
    sources = whole.sources[left]
    return SurfaceMesh(
        vertices=frozen(whole.vertices[left], np.float64),
        faces=frozen(faces, np.int32),
        normals=frozen(_agreeing(whole.vertices[left], faces, normals[left]), np.float32),
        colors=None if mesh.colors is None else frozen(mesh.colors[sources], np.uint8),
        filled=frozen(mesh.filled[origins[whole.origins[kept]]], np.bool_),
        facts={
            **mesh.facts, **counts, 'crowded_edges': whole.crowded_edges,
            'split_vertices': whole.split_vertices,
            **_facts(whole.vertices[left], faces, mates, manifold=True),
            'filled_share': _share(
                areas(whole.vertices[left], faces), mesh.filled[origins[whole.origins[kept]]])},
    )


def mesh_facts(vertices: Floats, faces: Ints) -> dict[str, Fact]:
    """
    Tell what kind of mesh this is.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    dict
        `vertices`, `faces`, `closed` (every edge has two faces or more), `manifold` (every edge
        has at most two, every vertex one fan), `oriented` (neighbours turn the same way),
        `components`, `boundary_edges`, `holes` (loops that these form), `area`, and `volume` if
        closed and oriented.
    """
    order, first = grouped_sides(faces)
    count = np.diff(first)
    mates = simple_mates(faces, order, first)
    begin, _ = ends(faces)
    sides = np.flatnonzero(mates >= 0)
    fan_count, _ = fans(mates)
    manifold = bool((count <= 2).all()) and fan_count == len(np.unique(faces))
    oriented = not (begin[sides] == begin[mates[sides]]).any()
    closed = bool(len(faces)) and not (count == 1).any()
    return _facts(
        vertices, faces, mates, manifold=manifold, oriented=oriented, closed=closed)


def _facts(
    vertices: Floats, faces: Ints, mates: Longs, *, manifold: bool, oriented: bool = True,
    closed: bool | None = None,
) -> dict[str, Fact]:
    loops, border = border_loops(faces, mates)
    if closed is None:
        closed = bool(len(faces)) and not len(border)
    facts: dict[str, Fact] = {
        'vertices': len(vertices), 'faces': len(faces), 'closed': closed, 'manifold': manifold,
        'oriented': oriented, 'components': face_components(mates)[0],
        'boundary_edges': len(border), 'holes': loops,
        'area': float(areas(vertices, faces).sum())}
    if closed and oriented:
        facts['volume'] = float(six_volumes(vertices, faces).sum() / 6)
    return facts


def _kept_mates(mates: Longs, kept: Bools) -> Longs:
    """Renumber the sides that are left with their faces; whole pieces go or stay."""
    number = np.cumsum(kept) - 1
    left = mates.reshape(-1, 3)[kept].ravel()
    return np.where(left < 0, -1, 3 * number[left // 3] + left % 3)


def _check(mesh: SurfaceMesh, resolution: float) -> None:
    if not (np.isfinite(resolution) and resolution > 0):
        raise ShapeError(f'resolution: expected a length above 0, got {resolution}')
    if not np.isfinite(mesh.vertices).all():
        raise ShapeError('vertices of the surface: not finite')
    if mesh.faces.size and (
            mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices)):
        raise ShapeError(
            f'faces of the surface: indices must lie in 0..{len(mesh.vertices) - 1}')


def _share(area: Floats, of: Bools) -> float:
    total = float(area.sum())
    return float(area[of].sum()) / total if total > 0 else 0.0


def _agreeing(vertices: Floats, faces: Ints, normals: Floats) -> Floats:
    """Return the normals, turned to the side of the faces; theirs where nothing is known."""
    flat = vertex_normals(vertices, faces)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = normals / np.where(length > 0, length, 1.0)
    unit = np.where(np.einsum('ij,ij->i', unit, flat)[:, None] < 0, -unit, unit)
    return np.where(length > 0, unit, flat)
