# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Play a recording into a station: ``ros2 launch ros_rops replay.launch.py recording:=FILE``.

The station is that of station.launch.py, listening to what the recording holds.
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import (
    DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction, RegisterEventHandler,
    Shutdown)
from launch.event_handlers import OnProcessExit
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node
from ros_rops.core.errors import InputError
from ros_rops.recordings.playback import open_playback

STATION = Path(__file__).with_name('station.launch.py')
SWITCH = ('true', 'false')
# Arguments of station.launch.py that are handed on as they are.
OF_STATION = {
    'namespace': 'Of both nodes and all of their topics and frames.',
    'preset': 'Parameters of the station that come with the package, as in station.launch.py.',
    'params_file': 'A ROS parameter file of your own for the station, over the preset.',
    'output_folder': 'Where the station writes its runs (its parameter output.folder).',
    'rviz': 'Whether RViz is started too.',
    'fixed_frame': "RViz's fixed frame; object_0 of the namespace if empty.",
    'log_level': 'What both nodes log.',
}
# Parameters of replay_node: default as text, type, description.
OF_REPLAY = {
    'topics': ('', str, 'Topics of the recording, parted by spaces; empty: all point clouds, '
               'else the depth images.'),
    'mode': ('lock_step', str, 'lock_step (the next frame when the station has had its say on '
             'the last) or clock (at its recorded time).'),
    'rate': ('1.0', float, 'So many times as fast as recorded (mode clock).'),
    'start_offset_s': ('0.0', float, 'Begin so many seconds after the first frame.'),
    'loops': ('1', int, 'Play it so many times; 0 for again and again.'),
    'finish': ('true', bool, "Whether the station's ~/finish is called at the end."),
    'save': ('true', bool, 'And its ~/save.'),
}
DEFAULTS = {'rviz': 'false', 'log_level': 'info'}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the nodes made of them."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'recording', description='MCAP file, rosbag2 folder or ROS 1 bag.'),
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, (default, _, description) in OF_REPLAY.items()),
        *(DeclareLaunchArgument(
            name, default_value=DEFAULTS.get(name, ''), description=description)
          for name, description in OF_STATION.items()),
        DeclareLaunchArgument(
            'shutdown', default_value='false', choices=SWITCH,
            description='Whether everything ends when the replay has ended.'),
        OpaqueFunction(function=_actions),
    ])


def _actions(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    given = context.launch_configurations
    recording = Path(given['recording']).expanduser().resolve()
    replay = Node(
        package='ros_rops', executable='replay_node', name='rops_replay',
        namespace=given['namespace'], output='both', emulate_tty=True,
        parameters=[{'recording': str(recording), **_parameters(given)}],
        ros_arguments=['--log-level', given['log_level']])
    actions = [_station(given, recording), replay]
    if given['shutdown'] == 'true':
        actions.append(RegisterEventHandler(OnProcessExit(
            target_action=replay, on_exit=[Shutdown(reason='the replay has ended')])))
    return actions


def _parameters(given: dict[str, str]) -> dict[str, str | float | int | bool]:
    """Return the replay's parameters in their types."""
    values = {}
    for name, (_, kind, _) in OF_REPLAY.items():
        try:
            values[name] = given[name] == 'true' if kind is bool else kind(given[name])
        except ValueError:
            raise RuntimeError(f'{name}: expected {kind.__name__}, got {given[name]!r}') from None
    return values


def _station(given: dict[str, str], recording: Path) -> IncludeLaunchDescription:
    """Return the station, listening to the kind of frames that the recording holds."""
    try:
        with open_playback(recording, tuple(given['topics'].split())) as playback:
            kind, color = playback.kind, playback.color
    except InputError as error:
        raise RuntimeError(str(error)) from error
    own = {'views': 'views'} if kind == 'cloud' else {
        'depth_image': 'depth/image', 'color': str(color).lower()}
    arguments = {
        **{name: given[name] for name in OF_STATION}, **own, 'autostart': 'true',
        'use_sim_time': str(given['mode'] == 'clock').lower()}
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(STATION)), launch_arguments=list(arguments.items()))
