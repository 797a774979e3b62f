# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What segmentation hands on: the views, and why every other point was dropped."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from numpy.typing import NDArray
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, RangeView, SupportPlane


class Label(IntEnum):
    """What became of a point of a frame."""

    HOLE = 0
    KEPT = 1
    TOO_NEAR = 2
    TOO_FAR = 3
    OUTSIDE_BOX = 4
    BACKGROUND = 5
    PLANE = 6
    BELOW_PLANE = 7
    BESIDE_PLANE = 8
    NOT_STANDING = 9
    EDGE = 10
    SPECK = 11
    OTHER_OBJECT = 12


REASONS: Mapping[Label, str] = {
    Label.HOLE: 'not measured',
    Label.KEPT: 'kept',
    Label.TOO_NEAR: 'nearer than segmentation.near_m',
    Label.TOO_FAR: 'farther than segmentation.far_m',
    Label.OUTSIDE_BOX: 'outside of the crop box',
    Label.BACKGROUND: 'no nearer than the background frame',
    Label.PLANE: 'on the supporting plane',
    Label.BELOW_PLANE: 'below the supporting plane',
    Label.BESIDE_PLANE: 'beside the supporting plane',
    Label.NOT_STANDING: 'above the supporting plane, on no object that stands on it',
    Label.EDGE: 'between surfaces at a depth edge',
    Label.SPECK: 'together too few or too low for an object',
    Label.OTHER_OBJECT: 'on an object that segmentation.objects does not ask for',
}

MOST_REASONS = 3
"""So many reasons are told of a frame without a view."""


@dataclass(frozen=True, slots=True)
class PlaneFound:
    """
    The supporting plane of a frame.

    Parameters
    ----------
    plane : SupportPlane
        In the frame's units.
    tilt_deg : float
        Angle between its normal and the direction to the sensor: 0 seen from straight above.
    distance : float
        From the sensor's origin to the plane, in the frame's units.
    inliers : int
        Points it was fitted to.
    noise : float
        Standard deviation of their distances from it, in the frame's units.
    """

    plane: SupportPlane
    tilt_deg: float
    distance: float
    inliers: int
    noise: float


@dataclass(frozen=True, slots=True)
class Segmentation:
    """
    A frame cut into views.

    Parameters
    ----------
    frame : Frame
    views : tuple of RangeView
        In the frame's units, the grid cropped to the object if it was segmented; named as the
        frame, or '<frame>/0', '<frame>/1', ... where it was split.
    labels : (H, W) or (N,) uint8
        `Label` of every point.
    objects : (H, W) or (N,) int16
        Index into `views` of the points kept, -1 elsewhere.
    counts : mapping of Label to int
        Points by label; they sum to the frame's.
    plane : PlaneFound or None
    segmented : bool
        Whether plane and objects were looked for.
    notes : tuple of str
        What was assumed or not found, one sentence each.
    """

    frame: Frame
    views: tuple[RangeView, ...]
    labels: Bytes
    objects: NDArray
    counts: Mapping[Label, int]
    plane: PlaneFound | None = None
    segmented: bool = False
    notes: tuple[str, ...] = ()

    @property
    def untouched(self) -> bool:
        """Whether everything measured was kept and nothing looked for: the frame is the view."""
        dropped = sum(self.counts.values()) - self.counts[Label.KEPT] - self.counts[Label.HOLE]
        return not self.segmented and dropped == 0

    @property
    def why_empty(self) -> str:
        """Why there is no view: what was noted, and the largest reasons with their points."""
        dropped = [
            (count, label) for label, count in self.counts.items()
            if count and label not in (Label.KEPT, Label.HOLE)]
        dropped.sort(key=lambda one: (-one[0], one[1]))
        said = [f'{count} points {REASONS[label]}' for count, label in dropped[:MOST_REASONS]]
        start = '; '.join(self.notes) or 'no object was found'
        return f'{start}: {", ".join(said) or "nothing is measured"}'
