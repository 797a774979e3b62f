# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A raw sensor frame: what a message holds before anything is cut out of it."""

from dataclasses import dataclass

from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bytes, Floats32or64, RangeView, SensorModel, Units

LARGEST = 1e15
"""A coordinate beyond this is no measurement (uninitialised memory): a hole."""


@dataclass(frozen=True, slots=True)
class Frame:
    """
    What a sensor delivered at one time, holes included.

    Parameters
    ----------
    name : str
        `<topic>@<log time in ns>`; unique within a recording.
    points : (H, W, 3) or (N, 3), float32 or float64
        Organized or not, in the sensor's frame, as the message has them (no copy is made of
        float32). A hole is NaN in z; nothing beyond `LARGEST` is a measurement.
    colors : (H, W, 3) or (N, 3) uint8, or None
        Red, green, blue.
    sensor : SensorModel or None
        None where it must be inferred from the points.
    units : {'m', 'mm', 'unknown'}
    stamp_ns : int or None
        Time of capture (the header's).
    frame_id : str
        The sensor's frame.
    topic : str
    log_time_ns : int or None
        Time of recording.
    notes : tuple of str
        What had to be assumed, one sentence each.
    view : RangeView or None
        The view that this is, where the recording says so: nothing is to be cut out of it.

    Raises
    ------
    ShapeError
        If `points` has another shape, or `colors` does not fit it.
    """

    name: str
    points: Floats32or64
    colors: Bytes | None = None
    sensor: SensorModel | None = None
    units: Units = 'm'
    stamp_ns: int | None = None
    frame_id: str = ''
    topic: str = ''
    log_time_ns: int | None = None
    notes: tuple[str, ...] = ()
    view: RangeView | None = None

    def __post_init__(self) -> None:
        """Check shapes."""
        if self.points.ndim not in (2, 3) or self.points.shape[-1] != 3:
            raise ShapeError(
                f'points of {self.name!r}: expected (H, W, 3) or (N, 3), got {self.points.shape}')
        if self.colors is not None and self.colors.shape != self.points.shape:
            raise ShapeError(
                f'colors of {self.name!r}: {self.colors.shape} != {self.points.shape}')

    @property
    def organized(self) -> bool:
        """Whether there is one point, or hole, per pixel."""
        return self.points.ndim == 3
