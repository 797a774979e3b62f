# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The surface in a volume of bricks: marching cubes where all eight corners are known."""

from collections import defaultdict
from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats, Ints
from ros_rops.kernels.volume import BRICK, Distances

_BRICKS = 4
"""Bricks along a side of the blocks that are handed to marching cubes."""
_CUBES = _BRICKS * BRICK

Block = tuple[int, int, int]
Part = tuple[int, tuple[slice, ...], tuple[slice, ...]]


class Extracted(NamedTuple):
    """
    A surface, in voxels from the volume's origin.

    Parameters
    ----------
    vertices : (V, 3) float64
        Each on an edge between two voxels (or within a cube), and there once.
    faces : (F, 3) int32
        Counter-clockwise seen from the positive side.
    """

    vertices: Floats
    faces: Ints


def extract(distances: Distances, steepest: float = np.inf) -> Extracted:
    """
    Extract the surface at distance zero (Lewiner et al. 2003, by scikit-image).

    Cubes with an unknown corner give no face: there the surface has a hole. Blocks of bricks are
    done one after the other, so that memory follows the surface; what they have in common is
    welded by the voxels that a vertex lies between.

    Parameters
    ----------
    distances : Distances
    steepest : float
        Cubes whose corners differ by more than that, in voxels, have no surface either: a plane
        makes 1.7 at most. More comes where one view saw through and another only knows that its
        surface lies in front.

    Returns
    -------
    Extracted
        Without vertices if there is no surface.
    """
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0
    for block, parts in sorted(_parts(distances.bricks).items()):
        found = _marched(_assembled(distances.values, parts), steepest)
        if found is not None:
            vertices.append(found[0] + np.multiply(block, float(_CUBES)))
            faces.append(found[1] + count)
            count += len(found[0])
    return _welded(np.concatenate(vertices), np.concatenate(faces))


def _parts(bricks: Ints) -> dict[Block, list[Part]]:
    """Return for each block the bricks in it; also those that its last cubes reach into."""
    parts: dict[Block, list[Part]] = defaultdict(list)
    homes, places = np.divmod(bricks, _BRICKS)
    for number, (home, place) in enumerate(zip(homes.tolist(), places.tolist(), strict=True)):
        # The first voxels of a block are the last ones of the block before it.
        for back in product(*((0, 1) if at == 0 else (0,) for at in place)):
            block = (home[0] - back[0], home[1] - back[1], home[2] - back[2])
            source = tuple(slice(0, 1 if before else BRICK) for before in back)
            target = tuple(
                slice(_CUBES, _CUBES + 1) if before else slice(at * BRICK, (at + 1) * BRICK)
                for before, at in zip(back, place, strict=True))
            parts[block].append((number, source, target))
    return parts


def _assembled(values: NDArray[np.float32], parts: list[Part]) -> NDArray[np.float32]:
    block = np.full((_CUBES + 1,) * 3, np.nan, np.float32)
    for number, source, target in parts:
        block[target] = values[number][source]
    return block


def _marched(
    block: NDArray[np.float32], steepest: float
) -> tuple[Floats, NDArray[np.int64]] | None:
    from skimage import measure  # takes half a second to import

    marching_cubes: Callable[..., tuple[NDArray, ...]] = measure.marching_cubes
    known = np.isfinite(block)
    if not ((block < 0).any() and (block > 0).any()):
        return None
    # With unknown corners the span is not finite.
    low, high = block[1:, 1:, 1:].copy(), block[1:, 1:, 1:].copy()
    for i, j, k in product((0, 1), repeat=3):
        corner = block[i:i + _CUBES, j:j + _CUBES, k:k + _CUBES]
        np.minimum(low, corner, out=low)
        np.maximum(high, corner, out=high)
    cubes = np.zeros_like(known)
    cubes[1:, 1:, 1:] = high - low <= steepest  # scikit-image looks at a cube's last corner
    try:
        vertices, faces, _, _ = marching_cubes(
            np.where(known, block, np.float32(1)), 0.0, mask=cubes)
    except RuntimeError:  # no cube that it may look at has a surface
        return None
    return vertices.astype(np.float64), faces.astype(np.int64)


def _welded(vertices: Floats, faces: NDArray[np.int64]) -> Extracted:
    """Make one of the vertices that two blocks made on an edge in the wall between them."""
    base = np.floor(vertices)
    whole = vertices == base
    wall = np.flatnonzero((whole & (base % _CUBES == 0)).any(axis=1))
    edges = np.column_stack([base[wall], whole[wall]]).astype(np.int64)
    _, first, back = np.unique(edges, axis=0, return_index=True, return_inverse=True)
    numbers = np.arange(len(vertices))
    numbers[wall] = wall[first[back.reshape(-1)]]
    used = numbers == np.arange(len(vertices))
    compact = np.cumsum(used) - 1
    return Extracted(vertices[used], compact[numbers[faces]].astype(np.int32))
