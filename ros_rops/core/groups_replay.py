# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the node that plays a recording into the station's topics."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class ReplayConfig(Group):
    """What is played, and how; these parameters stand without a group."""

    recording: str = param(
        '', 'What to play: MCAP file, rosbag2 folder or ROS 1 bag. It must be given.')
    topics: str = param(
        '', 'Topics of the recording to play, parted by spaces: of point clouds, or one of depth '
        'images; empty for all point clouds, else the only depth images.')
    mode: str = param(
        'lock_step', 'Send the next frame when the station has had its say on the last '
        '(lock_step: the same result every time), or at its recorded time, with /clock (clock).',
        choices=('lock_step', 'clock'))
    rate: float = param(
        1.0, "Play so many times as fast as recorded (mode 'clock').", low=0.001, high=1000.0)
    start_offset_s: float = param(
        0.0, 'Begin so long after the first frame of the recording.', unit='s',
        low=0.0, high=1e9)
    loops: int = param(
        1, 'Play it so many times; 0 for again and again.', low=0, high=1000000000)
    tf: bool = param(True, 'Send the transforms of the recording to /tf and /tf_static too.')
    station: str = param(
        'rops_registration', "Name of the station's node, of the same namespace unless it begins "
        'with a slash; its services ~/finish and ~/save are called where that is asked for.')
    finish: bool = param(False, "Call the station's ~/finish at the end.")
    save: bool = param(False, "Call the station's ~/save at the end.")
    wait_s: float = param(
        60.0, 'Wait so long for the station to listen before giving up.', unit='s',
        low=0.0, high=1e6)
    reply_timeout_s: float = param(
        120.0, 'Wait so long for its word on a frame, or the answer of a service, before giving '
        'up.', unit='s', low=0.1, high=1e6)


def topics_of(config: ReplayConfig) -> tuple[str, ...]:
    """Return the topics that are named."""
    return tuple(config.topics.split())
