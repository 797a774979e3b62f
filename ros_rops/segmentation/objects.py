# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which connected parts make an object: those that stand on the plane, and what belongs to them.

A part hovers where its contact with the plane is not seen. A head before a body belongs to the
nearest part that stands, if it is no farther from it than that one is large. An object whose foot
is hidden, by its own belly or by another object before it, has no plane to be seen below: it
stands, too, where it is not near to another. What reaches into the image and is near to nothing
is a hand or a cable. A small part that stands close to a much larger one, with nothing of the
plane to be seen between, is a piece of it: a leg.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, Ints
from ros_rops.segmentation.ground import rim_of
from ros_rops.segmentation.plane import Support
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.scan import Image, Scan
from scipy.spatial import cKDTree

FRAGMENT = 20
"""A part of fewer points is a speck, even near an object."""
LOW = 2.0
"""A part nine tenths of which rise less than so many bands of noise is a wave of the plane."""
MOST_PARTS = 48
"""The largest parts that are looked at; the others are specks."""
SAMPLE = 1000
"""Points of a part that tell its place and its distance from others."""
PIECE = 0.2
"""A piece has at most this share of the points of the part that it belongs to ..."""
NEAR = 0.5
"""... and is nearer than this share of that one's size."""
HIDDEN = 0.2
"""The foot of a part may be hidden if below this share of it the plane is not seen."""
OWN = 0.35
"""Such a part is an object if, on the plane, it is this share of their size from others ..."""
OWN_POINTS = 0.05
"""... and has this share of its points."""
REACHES = 0.25
"""What hovers and reaches out of the image is of an object this share of its size away."""


@dataclass(frozen=True, slots=True)
class Part:
    """
    A connected part, or several that were found to be one object.

    Parameters
    ----------
    numbers : tuple of int
        The connected parts'.
    size : int
        Points.
    index : (S,) int
        Points of the frame that tell its place.
    sample : (S, 3) float64
        Where these are.
    stands : bool
        Whether it reaches down to the plane.
    reaches : bool
        Whether it reaches out of the image.
    hidden : float
        Of a part that hovers: share below which the plane is not seen.
    places : (S, 2) float64, or None
        The sample on the plane, where some part is in doubt.
    """

    numbers: tuple[int, ...]
    size: int
    index: NDArray
    sample: Floats
    stands: bool
    reaches: bool = False
    hidden: float = 0.0
    places: Floats | None = None

    @property
    def extent(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.sample, axis=0)))

    def joined(self, other: 'Part') -> 'Part':
        """Return both as one."""
        both = [part.places for part in (self, other) if part.places is not None]
        places = np.concatenate(both) if len(both) == 2 else None
        return Part(
            self.numbers + other.numbers, self.size + other.size,
            np.concatenate([self.index, other.index]),
            np.concatenate([self.sample, other.sample]), self.stands or other.stands,
            self.reaches or other.reaches, self.hidden, places)


def group_parts(
    parts: list[Part], gap: float, least: int, plane: NDArray | None
) -> tuple[list[Part], list[Part]]:
    """
    Return the objects, each as one part, and the parts that are of none.

    Parameters
    ----------
    parts : list of Part
        If none stands, nor may, those near one another are objects.
    gap : float
        Standing parts closer than this are one object.
    least : int
        Points of an object, at least.
    plane : (H, W) bool or None
        Where the plane is seen, for an organized frame.
    """
    objects = [part for part in parts if part.stands]
    hovering = [part for part in parts if not part.stands]
    # Large ones first: their fragments would make a chain from one object to another.
    enough = max([least, *(OWN_POINTS * part.size for part in parts)])
    large = [part for part in hovering if part.size >= enough]
    small = [part for part in hovering if part.size < enough]
    while large:
        objects, large = _attached(objects, large, gap, least)
        alone = not any(part.size >= least for part in objects)
        roots = [
            part for part in large if part.hidden >= HIDDEN and (alone or not part.reaches)]
        if not roots:
            break
        # What reaches out of the image comes last: it may be a hand.
        root = min(roots, key=lambda part: (part.reaches, -part.size))
        large = [part for part in large if part is not root]
        objects.append(replace(root, stands=True))
    objects, hovering = _attached(objects, large + small, gap, least)
    if not any(part.size >= least for part in objects):
        return _merged(objects + hovering, gap, plane), []
    return _merged(objects, gap, plane), hovering


def _attached(
    objects: list[Part], hovering: list[Part], gap: float, least: int
) -> tuple[list[Part], list[Part]]:
    """Join what hovers to the objects that it is of; return these, and what is left."""
    objects, hovering = list(objects), list(hovering)
    apart = np.array([
        [_apart(part.sample, one.sample, one.extent) for one in objects]
        for part in hovering]).reshape(len(hovering), len(objects))
    while apart.size:
        # The nearest first: an upper half may hold on to a foot, and what is before it to both.
        row, best = (int(k) for k in np.unravel_index(int(np.argmin(apart)), apart.shape))
        if not np.isfinite(apart[row, best]):
            break
        if not _belongs(hovering[row], objects[best], float(apart[row, best]), gap, least):
            apart[row, best] = np.inf
            continue
        joining = hovering.pop(row)
        objects[best] = objects[best].joined(joining)
        apart = np.delete(apart, row, axis=0)
        for k, part in enumerate(hovering):
            near = _apart(part.sample, joining.sample, objects[best].extent)
            apart[k, best] = min(apart[k, best], near)
    return objects, hovering


def _belongs(part: Part, other: Part, apart: float, gap: float, least: int) -> bool:
    """Return whether a part that hovers is of an object."""
    if apart > other.extent * (REACHES if part.reaches else 1.0):
        return False
    own = part.hidden >= HIDDEN and part.size >= max(least, OWN_POINTS * other.size)
    if not own or part.places is None or other.places is None:
        return True
    if other.size < least:
        return False  # a splinter that stands would make a chain, too
    limit = max(gap, OWN * float(np.sqrt(part.extent * other.extent)))
    return _apart(part.places, other.places, limit) <= limit


def _merged(objects: list[Part], gap: float, plane: NDArray | None) -> list[Part]:
    """Join objects until no two of them are one."""
    for j, second in enumerate(objects):
        for i, first in enumerate(objects[:j]):
            if _one_object(first, second, gap, plane):
                rest = [part for k, part in enumerate(objects) if k not in (i, j)]
                return _merged([first.joined(second), *rest], gap, plane)
    return objects


def _one_object(first: Part, second: Part, gap: float, plane: NDArray | None) -> bool:
    small, large = sorted((first, second), key=lambda part: part.size)
    apart = _apart(small.sample, large.sample, max(gap, large.extent))
    if not small.stands and not large.stands:
        return apart <= large.extent
    if apart <= gap:
        return True
    if small.hidden >= HIDDEN or small.size > PIECE * large.size:
        return False
    piece = apart <= NEAR * large.extent
    return piece and plane is not None and not _seen_between(plane, small, large)


def _apart(first: Floats, second: Floats, most: float) -> float:
    """Return the least distance between two sets of points; infinite if surely beyond `most`."""
    gap = np.maximum(
        first.min(axis=0) - second.max(axis=0), second.min(axis=0) - first.max(axis=0))
    if np.linalg.norm(np.maximum(gap, 0.0)) > most:
        return np.inf
    return float(cKDTree(second).query(first)[0].min())


def _seen_between(plane: NDArray, first: Part, second: Part) -> bool:
    """Return whether the plane is seen where two parts are nearest to each other in the image."""
    pixels = [
        np.stack(np.unravel_index(part.index, plane.shape), axis=1).astype(np.float64)
        for part in (first, second)]
    apart, nearest = cKDTree(pixels[1]).query(pixels[0])
    start = int(np.argmin(apart))
    line = np.linspace(pixels[0][start], pixels[1][nearest[start]], int(apart[start]) + 2)
    rows, columns = np.rint(line).astype(np.int64).T
    return int(np.count_nonzero(plane[rows, columns])) >= 2


def look_at_parts(
    scan: Scan, numbers: Ints, count: int, heights: Image, band: Image,
    support: Support | None, step: float, labels: Bytes,
) -> list[Part]:
    """
    Return the parts over the plane's extent, the others labelled and taken out of `numbers`.

    Parameters
    ----------
    scan : Scan
    numbers : (N,) int32
        Part of every point, 0 for none; changed in place.
    count : int
        Number of parts.
    heights, band : (N,) float
        Over the plane, and how far its noise reaches.
    support : Support or None
        Without one every part stands.
    step : float
        Distance of neighbouring points at depth 1 (organized) or everywhere.
    labels : (N,) uint8
        Changed in place.
    """
    rim = rim_of(scan)
    which = np.flatnonzero(numbers)
    kind = np.uint16 if count < 65536 else np.int32  # a radix sort, where it can be
    which = which[np.argsort(numbers[which].astype(kind), kind='stable')]
    sizes = np.bincount(numbers[which], minlength=count + 1)
    starts = np.cumsum(sizes) - sizes
    large = [k for k in np.argsort(-sizes, kind='stable')[:MOST_PARTS] if sizes[k] >= FRAGMENT]
    parts = []
    for k in sorted(int(k) for k in large):
        members = which[starts[k]:starts[k] + sizes[k]]
        if support is not None:
            members = _over(scan, members, support, numbers, labels)
        if len(members) >= FRAGMENT and (
                support is None or (heights[members] > LOW * band[members]).mean() > 0.1):
            part = _part(scan, k, members, heights, band, support, step)
            reaches = rim is not None and rim.touched_by(members)
            parts.append(replace(part, reaches=reaches))
    seen = np.zeros(count + 1, bool)
    seen[[part.numbers[0] for part in parts]] = True
    few = (numbers > 0) & ~seen[numbers]
    labels[few] = Label.SPECK
    numbers[few] = 0
    return parts


def _thin(members: NDArray) -> NDArray:
    return members[np.linspace(0, len(members) - 1, min(SAMPLE, len(members))).astype(np.int64)]


def _over(
    scan: Scan, members: NDArray, support: Support, numbers: Ints, labels: Bytes
) -> NDArray:
    """Return the members over the plane's extent, if most are not; else all of them."""
    inside = support.extent.holds(scan.take(_thin(members)), support.margin)
    if inside.mean() >= 0.5:
        return members
    over = np.zeros(len(members), bool)
    if inside.any():
        over = support.extent.holds(scan.take(members), support.margin)
    labels[members[~over]] = Label.BESIDE_PLANE
    numbers[members[~over]] = 0
    return members[over]


def _part(
    scan: Scan, number: int, members: NDArray, heights: Image, band: Image,
    support: Support | None, step: float,
) -> Part:
    index = _thin(members)
    sample = scan.take(index)
    if support is None:
        return Part((number,), len(members), index, sample, True)
    own = heights[members]
    rank = min(4, len(own) - 1)
    lowest = int(np.argpartition(own, rank)[rank])
    depth = scan.depth[members[lowest]]
    near = 3 * float(band[members[lowest]]) + 3 * step * float(depth if scan.shape else 1.0)
    near += 0.05 * float(own.max())
    return Part((number,), len(members), index, sample, bool(own[lowest] <= near))
