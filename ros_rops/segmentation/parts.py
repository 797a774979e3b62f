# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Connected parts of what rises from the plane, and their feet, which the plane's noise hides."""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.types import Bools, Ints
from ros_rops.segmentation.cells import grow_in_cloud, parts_of_cloud
from ros_rops.segmentation.edges import Edges, find_edges
from ros_rops.segmentation.pixels import grow, label_parts
from ros_rops.segmentation.scan import Image, Scan
from scipy import ndimage

LOW = 0.25
"""A foot is followed down to this share of the plane's band ..."""
WIDE = 3.0
"""... and this many bands sideways, ..."""
STEPS = (2, 12)
"""... in pixels at least and at most."""


@dataclass(frozen=True, slots=True)
class Parts:
    """
    Connected parts of a frame.

    Parameters
    ----------
    scan : Scan
    numbers : (N,) int32
        Part of every point, 0 for none.
    count : int
    hanging : (N,) bool
        Points that hang between surfaces and are of no part.
    edges : Edges or None
        None for an unorganized frame.
    """

    scan: Scan
    numbers: Ints
    count: int
    hanging: Bools
    edges: Edges | None

    def grow_feet(
        self, numbers: Ints, usable: Bools, heights: Image, band: Image, step: float
    ) -> None:
        """
        Let objects spread down into the plane's noise.

        A foot's points within the noise are those linked to the object that rise from the plane
        on the mean over their neighbours; the plane's own points do not rise.

        Parameters
        ----------
        numbers : (N,) int32
            Object of every point, 0 for none; changed in place.
        usable : (N,) bool
        heights, band : (N,) float
            Over the plane, and how far its noise reaches.
        step : float
            Distance of neighbouring points: at depth 1 (organized) or everywhere.
        """
        foot = usable & (heights > 0) & (heights <= band)
        if not numbers.any() or not foot.any():
            return
        if self.edges is None:
            _grow_in_cloud(self.scan, numbers, foot & (heights > LOW * band), band, step)
            return
        taken = self.scan.image(numbers > 0)
        median = float(np.median(band[foot] / np.maximum(self.scan.depth[foot], 1e-12)))
        wide = WIDE * median / max(step, 1e-12)
        steps = int(np.clip(np.ceil(wide), *STEPS))
        box = _span(taken, 1, steps), _span(taken, 0, steps)
        _grow_on_grid(
            self.scan.image(numbers), self.scan.image(foot), self.scan.image(heights),
            self.scan.image(band), self.scan.image(usable), self.edges, box, steps)


def _span(taken: Bools, axis: int, more: int) -> slice:
    index = np.flatnonzero(taken.any(axis=axis))
    return slice(max(0, int(index[0]) - more), int(index[-1]) + more + 1)


def _grow_on_grid(
    numbers: Ints, foot: Bools, heights: Image, band: Image, usable: Bools, edges: Edges,
    box: tuple[slice, slice], steps: int,
) -> None:
    rows, columns = box
    limit = band[box]
    good = usable[box].astype(np.float32)
    flat = np.clip(heights[box], -limit, 2 * limit) * good
    mean = ndimage.uniform_filter(flat, 3) / np.maximum(ndimage.uniform_filter(good, 3), 1e-6)
    near = ndimage.maximum_filter((numbers[box] > 0).astype(np.uint8), 2 * steps + 1) > 0
    into = foot[box] & near & (mean > LOW * limit)
    part = Edges(
        edges.right[rows, columns.start:columns.stop - 1],
        edges.down[rows.start:rows.stop - 1, columns], edges.hanging[box], edges.far[box])
    grow(numbers[box], into & ~part.hanging, part, steps)


def _grow_in_cloud(
    scan: Scan, numbers: Ints, foot: Bools, band: Image, step: float
) -> None:
    into = np.flatnonzero(foot)
    reach = WIDE * float(np.median(band[into])) + 2 * step if len(into) else 0.0
    grow_in_cloud(numbers, scan.take(slice(None)), into, np.flatnonzero(numbers), reach)


def parts_of_pixels(
    scan: Scan, usable: Bools, up: Bools, noise: Image, pitch: tuple[float, float],
    config: SegmentationConfig,
) -> Parts:
    """
    Return the connected parts of what is `up` in an organized frame.

    Parameters
    ----------
    scan : Scan
    usable, up : (N,) bool
        Depth edges are looked for between usable points.
    noise : (N,) float
        Standard deviation of the depth.
    pitch : (float, float)
        Lateral distance of neighbouring pixels at depth 1: along a row, along a column.
    config : SegmentationConfig
    """
    edges = find_edges(
        scan.image(scan.depth), scan.image(usable), scan.image(noise), pitch, config.edge_deg)
    hanging = edges.hanging.ravel()
    numbers, count = label_parts(scan.image(up & ~hanging), edges)
    return Parts(scan, numbers.ravel(), count, hanging, edges)


def parts_of_points(scan: Scan, up: Bools, spacing: float) -> Parts:
    """Return the connected parts of what is `up` (N,) in an unorganized frame."""
    numbers, count = parts_of_cloud(scan.take(up), up, spacing)
    return Parts(scan, numbers, count, np.zeros(len(up), bool), None)
