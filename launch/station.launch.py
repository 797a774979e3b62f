# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Start the station's node, and RViz if asked: ``ros2 launch ros_rops station.launch.py``.

An argument left empty leaves its matter to the parameter files; one that is given stands over
them.
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import LifecycleNode, Node

SHARE = Path(__file__).parent.parent
SWITCH, SWITCH_OR_EMPTY = ('true', 'false'), ('', 'true', 'false')
# Name, default, choices (all where there are none), description.
ARGUMENTS = (
    ('namespace', '', (), 'Of the node and all of its topics and frames; one for each station.'),
    ('preset', '', (), 'Parameters that come with the package: turntable, handheld, kinect, '
     'structured_light; several with commas, later ones over earlier ones.'),
    ('params_file', '', (), 'A ROS parameter file of your own, over the preset.'),
    ('autostart', '', SWITCH_OR_EMPTY,
     'Whether the node configures and activates itself (parameter autostart).'),
    ('resume', '', SWITCH_OR_EMPTY, 'Whether it goes on with its last run (parameter resume).'),
    ('output_folder', '', (), 'Where it writes its runs (parameter output.folder).'),
    ('views', '', (), "The sensor's PointCloud2 topic; sets input.kind to cloud."),
    ('depth_image', '', (), "The sensor's depth image topic; sets input.kind to depth."),
    ('camera_info', '', (), "The depth image's CameraInfo topic; beside depth_image if empty."),
    ('color_image', '', (), 'The colour image topic, aligned to the depth image.'),
    ('color', '', SWITCH_OR_EMPTY, 'Whether the node listens to it (parameter input.color).'),
    ('use_sim_time', 'false', SWITCH, 'Whether time is that of /clock.'),
    ('log_level', 'info', ('debug', 'info', 'warn', 'error', 'fatal'), 'What the node logs.'),
    ('rviz', 'false', SWITCH, 'Whether RViz is started too.'),
    ('fixed_frame', '', (), "RViz's fixed frame; object_0 of the namespace if empty."),
)
SHOWN = ('assembled', 'markers')


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the nodes made of them."""
    return LaunchDescription([
        *(DeclareLaunchArgument(
            name, default_value=default, description=description, choices=choices or None)
          for name, default, choices, description in ARGUMENTS),
        OpaqueFunction(function=_nodes),
    ])


def _nodes(context: LaunchContext) -> list[Node]:
    given = {name: context.launch_configurations[name] for name, *_ in ARGUMENTS}
    nodes = [LifecycleNode(
        package='ros_rops', executable='registration_node', name='rops_registration',
        namespace=given['namespace'], parameters=[*_files(given), _over_files(given)],
        remappings=_remappings(given), ros_arguments=['--log-level', given['log_level']],
        output='both', emulate_tty=True)]
    return [*nodes, _rviz(given)] if given['rviz'] == 'true' else nodes


def _files(given: dict[str, str]) -> list[str]:
    """Return the parameter files, those that stand over others after them."""
    paths = [
        SHARE / 'config' / f'{name.strip()}.yaml'
        for name in given['preset'].split(',') if name.strip()]
    if given['params_file']:
        paths.append(Path(given['params_file']).expanduser())
    for path in paths:
        # launch_ros would go on with the defaults.
        if not path.is_file():
            raise RuntimeError(f'{path}: there is no such parameter file')
    return [str(path) for path in paths]


def _over_files(given: dict[str, str]) -> dict[str, bool | str]:
    """Return the parameters that arguments set."""
    values: dict[str, bool | str] = {'use_sim_time': given['use_sim_time'] == 'true'}
    values |= {
        name: given[name] == 'true' for name in ('autostart', 'resume') if given[name]}
    if given['color']:
        values['input.color'] = given['color'] == 'true'
    if given['output_folder']:
        values['output.folder'] = given['output_folder']
    if given['views'] and given['depth_image']:
        raise RuntimeError('views and depth_image: the node takes one of the two')
    if given['views'] or given['depth_image']:
        values['input.kind'] = 'cloud' if given['views'] else 'depth'
    return values


def _remappings(given: dict[str, str]) -> list[tuple[str, str]]:
    """Return which topic of the sensor stands for which of the node."""
    topics = {
        'views': given['views'],
        'depth/image': given['depth_image'],
        'depth/camera_info': given['camera_info'] or _beside(given['depth_image']),
        'color/image': given['color_image'],
    }
    return [(own, topic) for own, topic in topics.items() if topic]


def _beside(image: str) -> str:
    """Return where the CameraInfo of an image topic is by custom."""
    return image.rpartition('/')[0] + '/camera_info' if '/' in image else ''


def _rviz(given: dict[str, str]) -> Node:
    namespace = given['namespace'].strip('/')
    before = f'{namespace}/' if namespace else ''
    return Node(
        package='rviz2', executable='rviz2', name='rviz2', namespace=given['namespace'],
        arguments=['--display-config', str(SHARE / 'rviz' / 'station.rviz'),
                   '--fixed-frame', given['fixed_frame'] or f'{before}object_0'],
        # The file has the topics of a station without a namespace.
        remappings=[(f'/{topic}', f'/{before}{topic}') for topic in SHOWN if before],
        parameters=[{'use_sim_time': given['use_sim_time'] == 'true'}])
