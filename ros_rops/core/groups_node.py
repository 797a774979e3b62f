# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the station's node: what it listens to, what it publishes, where it writes."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class NodeGroup(Group):
    """What the node as a whole does; these parameters stand without a group."""

    autostart: bool = param(
        True, 'Configure and activate at start; false leaves that to a lifecycle manager.')
    resume: bool = param(
        False, 'Go on with the last run in output.folder if there is one; else begin anew.')
    threads: int = param(
        0, 'Threads of a registration; 0 for all cores. The result does not depend on it.',
        low=0, high=1024)
    nice: int = param(
        5, 'By so much registration gives way to what else wants the cores, as `nice` says: the '
        "sensor's driver, the node's own callbacks and services.", low=0, high=19)


@dataclass(frozen=True, slots=True)
class InputConfig(Group):
    """What the node listens to."""

    kind: str = param(
        'cloud', 'PointCloud2 on views (cloud), or depth/image with depth/camera_info (depth).',
        choices=('cloud', 'depth'))
    color: bool = param(
        True, "Listen to color/image too, aligned to the depth image (kind 'depth').")
    lens: str = param(
        'auto', 'Depth images are as the lens makes them (raw) or undistorted already '
        '(rectified); auto takes it from the name of their topic, by the custom of ROS image_rect '
        'and the like for the latter.', choices=('auto', 'raw', 'rectified'))
    units: str = param(
        'auto', 'Units of the coordinates; auto follows REP 103: metres.',
        choices=('auto', 'm', 'mm'))
    sensor: str = param(
        'auto', 'Rays of the sensor: all from the origin (pinhole), all along z (orthographic), '
        'not known, or told from the points (auto).',
        choices=('auto', 'pinhole', 'orthographic', 'unknown'))
    reliability: str = param(
        'auto', 'QoS asked of publishers; auto asks for reliable, and for best_effort where a '
        'publisher does not offer that.', choices=('auto', 'reliable', 'best_effort'))
    durability: str = param(
        'volatile', 'transient_local also gets what a publisher that offers it sent before.',
        choices=('volatile', 'transient_local'))
    depth: int = param(
        10, 'Messages that the middleware keeps for the node.', low=1, high=1000)
    most_frames: int = param(
        32, 'Frames that wait to be looked at; more overflow, which is counted and said.',
        low=1, high=10000)
    most_mb: int = param(
        512, 'And so many megabytes of them.', unit='MB', low=1, high=1000000)
    most_views: int = param(
        64, 'Views that wait to be registered; then frames wait.', low=1, high=10000)
    background: str = param(
        '', 'Recording whose first frame shows the station without an object; empty for none.')
    tf: bool = param(
        True, 'Listen to /tf and /tf_static, for segmentation.box_frame and prior.fixed_frame.')


@dataclass(frozen=True, slots=True)
class PublishConfig(Group):
    """What the node publishes."""

    spacing_mr: float = param(
        1.0, 'Thin assembled clouds to about this distance of points; 0 publishes all of them.',
        unit='mr', low=0.0, high=100.0)
    most_points: int = param(
        300000, 'Thin them further where they would have more points together.',
        low=1000, high=1000000000)
    frame_prefix: str = param(
        '', "Stands before object_<k> and view_<n> in frame names; empty takes the node's "
        'namespace, so that two stations share one TF tree.')
    objects: bool = param(True, 'Publish a cloud for each object too.')
    markers: bool = param(True, 'Publish frames and labels of views as markers.')
    tf: bool = param(True, 'Publish where objects are on /tf.')
    tf_rate_hz: float = param(10.0, 'So often.', unit='Hz', low=0.1, high=1000.0)
    skipped: bool = param(
        False, 'Report frames that were not selected too: as many as the sensor sends.')


@dataclass(frozen=True, slots=True)
class OutputConfig(Group):
    """Where the node writes."""

    folder: str = param(
        '', 'Each run has a folder in it, with the journal and what ~/save writes; empty for '
        '~/.ros/ros_rops/<node>.')
    journal: bool = param(
        True, 'Keep every view on disk before it is worked on, so that nothing is lost.')
    picture: bool = param(True, 'Draw picture.png when saving.')
    models: bool = param(
        True, 'Make models and quality.json after saving, in a process of its own.')
    report: bool = param(True, 'Then write report.html.')
