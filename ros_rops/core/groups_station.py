# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the station: which frames become views, what is cut out of them, what is known."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class SelectionConfig(Group):
    """Which frames of a stream become views."""

    method: str = param(
        'every', 'Take every frame, every k-th (stride), or one whenever the scene has come to '
        'rest and differs from the last taken (still).', choices=('every', 'stride', 'still'))
    stride: int = param(
        10, "Take one frame of so many (method 'stride').", low=1, high=1000000)


@dataclass(frozen=True, slots=True)
class SegmentationConfig(Group):
    """What of a frame is the object."""

    when: str = param(
        'auto', 'Segment frames that are organized and measured to their border, as raw ones of '
        'a depth sensor are (auto), all frames (always), or none (never).',
        choices=('auto', 'always', 'never'))


@dataclass(frozen=True, slots=True)
class PriorConfig(Group):
    """What is known of the station; used to find and to refuse poses, never to invent them."""

    plane: bool = param(
        False, 'The objects stand on the same foot in all views: poses must map the supporting '
        'plane of one view to that of the other.')
    axis: bool = param(
        False, 'The objects stand on a turntable before a fixed sensor: all poses turn about '
        'one axis, which is found from the data.')
