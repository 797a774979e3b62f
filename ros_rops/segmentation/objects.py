# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which connected parts make an object: those that stand on the plane, and what hovers near them.

A part hovers where its foot is hidden or its neck is: a head before a body. It belongs to the
nearest part that stands, if it is no farther from it than that one is large.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, Ints
from ros_rops.segmentation.plane import Support
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.scan import Image, Scan
from scipy.spatial import cKDTree

FRAGMENT = 20
"""A part of fewer points is a speck, even near an object."""
MOST_PARTS = 256
"""The largest parts that are looked at; the others are specks."""
SAMPLE = 1500
"""Points of a part that tell its place and its distance from others."""


@dataclass(frozen=True, slots=True)
class Part:
    """A connected part: its number, its points, a sample of them, and how it stands."""

    number: int
    size: int
    sample: Floats
    stands: bool

    @property
    def extent(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.sample, axis=0)))


def group_parts(parts: list[Part], gap: float) -> tuple[list[list[Part]], list[Part], bool]:
    """
    Return objects as lists of parts, the parts that are of none, and whether all hover.

    Parameters
    ----------
    parts : list of Part
    gap : float
        Standing parts closer than this are one object.
    """
    standing = [part for part in parts if part.stands]
    hovering = bool(parts) and not standing
    roots = standing or parts
    floating = [part for part in parts if not part.stands] if standing else []
    group = list(range(len(roots)))
    for i, first in enumerate(roots):
        for j in range(i):
            near = max(first.extent, roots[j].extent) if hovering else gap
            if group[i] != group[j] and distance(first, roots[j]) <= near:
                group = [group[j] if one == group[i] else one for one in group]
    objects: dict[int, list[Part]] = {}
    for part, one in zip(roots, group, strict=True):
        objects.setdefault(one, []).append(part)
    lost = []
    for part in floating:
        apart = [distance(part, root) for root in roots]
        best = int(np.argmin(apart))
        if apart[best] <= roots[best].extent:
            objects[group[best]].append(part)
        else:
            lost.append(part)
    return list(objects.values()), lost, hovering


def distance(first: Part, second: Part) -> float:
    """Return the least distance between the samples of two parts."""
    return float(cKDTree(first.sample).query(second.sample)[0].min())


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
        if len(members) >= FRAGMENT:
            parts.append(_part(scan, k, members, heights, band, support, step))
    seen = np.zeros(count + 1, bool)
    seen[[part.number for part in parts]] = True
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
    sample = scan.take(_thin(members))
    if support is None:
        return Part(number, len(members), sample, True)
    own = heights[members]
    rank = min(4, len(own) - 1)
    lowest = int(np.argpartition(own, rank)[rank])
    depth = scan.depth[members[lowest]]
    near = 3 * float(band[members[lowest]]) + 3 * step * float(depth if scan.shape else 1.0)
    near += 0.05 * float(own.max())
    return Part(number, len(members), sample, bool(own[lowest] <= near))
