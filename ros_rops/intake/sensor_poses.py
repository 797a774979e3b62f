# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Where the sensor stood when a view was taken, as TF knows it; views without that go on."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ros_rops.core.types import Floats, RangeView, Units

METRE: dict[Units, float] = {'m': 1.0, 'mm': 1000.0}
Lookup = Callable[[str, str, int | None], Floats | None]


def with_sensor_poses(
    views: Sequence[RangeView], fixed_frame: str, lookup: Lookup | None
) -> tuple[tuple[RangeView, ...], tuple[str, ...]]:
    """
    Give the views of a frame `T_fixed_sensor`, the pose of their sensor at their time.

    Parameters
    ----------
    views : sequence of RangeView
        One that has a pose keeps it.
    fixed_frame : str
        Where objects stand still; '' leaves all views as they are.
    lookup : callable or None
        As for `Intake.begin`, translations in metres.

    Returns
    -------
    views : tuple of RangeView
    notes : tuple of str
        Why there is no pose.
    """
    done: list[RangeView] = []
    missing = ''
    for view in views:
        if not fixed_frame or view.T_fixed_sensor is not None:
            done.append(view)
            continue
        metre, pose = METRE.get(view.units), None
        if metre is None:
            missing = 'its units are not known'
        elif view.stamp_ns is None:  # the latest pose may be of another place
            missing = 'it has no stamp'
        else:
            pose = lookup(fixed_frame, view.frame_id, view.stamp_ns) if lookup else None
            missing = '' if pose is not None else (
                f'TF does not tell where {view.frame_id!r} was in {fixed_frame!r}')
        if pose is not None and metre is not None:
            pose = pose.copy()
            pose[:3, 3] *= metre
        done.append(replace(view, T_fixed_sensor=pose))
    return tuple(done), ((f'no sensor pose is used: {missing}',) if missing else ())
