# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the station: which frames become views, what is cut out of them, what is known."""

from dataclasses import dataclass

from ros_rops.core.parameter import Group, param


@dataclass(frozen=True, slots=True)
class SelectionConfig(Group):
    """Which frames of a stream become views."""

    method: str = param(
        'every', 'Take every frame, every k-th (stride), one whenever the scene has come to '
        'rest and differs from the last taken (still), or none but those asked for by the '
        "node's service ~/capture (request).", choices=('every', 'stride', 'still', 'request'))
    stride: int = param(
        10, "Take one frame of so many (method 'stride').", low=1, high=1000000)
    still_frames: int = param(
        3, "The scene is at rest when so many frames in a row agree (method 'still').",
        low=2, high=1000)
    still_s: float = param(
        0.3, 'And when they span at least this time, by their stamps.', unit='s',
        low=0.0, high=60.0)
    new_share: float = param(
        0.01, 'The scene is new when this share of the measured places changed their depth since '
        'the last taken frame; half of it between two frames is motion.', low=0.0005, high=0.5)
    depth_noise: float = param(
        0.01, 'Depths change when they differ by more than this share of the depth at up to 1 m, '
        'and in proportion to the depth beyond.',
        low=0.0001, high=0.5)


@dataclass(frozen=True, slots=True)
class SegmentationConfig(Group):
    """What of a frame is the object."""

    when: str = param(
        'auto', 'Segment frames that are organized and measured to their border, as raw ones of '
        'a depth sensor are (auto), all frames (always), or none (never). The limits of depth, '
        'the box and the background act on all frames unless it is never.',
        choices=('auto', 'always', 'never'))
    near_m: float = param(
        0.0, 'Drop what is nearer to the sensor: along the optical axis of a camera, straight for '
        'others.', unit='m', low=0.0, high=1e6)
    far_m: float = param(
        1e6, 'Drop what is farther from the sensor.', unit='m', low=0.0, high=1e6)
    box_frame: str = param(
        '', "The crop box's frame; empty for the sensor's, else found by TF at the frame's time.")
    box_low_x_m: float = param(
        -1e6, 'Drop what lies outside of the crop box.', unit='m', low=-1e6, high=1e6)
    box_high_x_m: float = param(1e6, 'As box_low_x_m.', unit='m', low=-1e6, high=1e6)
    box_low_y_m: float = param(-1e6, 'As box_low_x_m.', unit='m', low=-1e6, high=1e6)
    box_high_y_m: float = param(1e6, 'As box_low_x_m.', unit='m', low=-1e6, high=1e6)
    box_low_z_m: float = param(-1e6, 'As box_low_x_m.', unit='m', low=-1e6, high=1e6)
    box_high_z_m: float = param(1e6, 'As box_low_x_m.', unit='m', low=-1e6, high=1e6)
    background_m: float = param(
        0.005, 'What is not nearer than the background frame by this is background: at 1 m, with '
        'the depth below and its square beyond; of unorganized frames, what lies within this.',
        unit='m', low=0.0, high=10.0)
    plane: bool = param(
        True, 'Find the plane that the object stands on, and take it away.')
    plane_least_share: float = param(
        0.05, 'A plane holds at least this share of the measured points.', low=0.001, high=1.0)
    plane_band: float = param(
        4.0, 'A point belongs to the plane within so many standard deviations of the noise that '
        'is measured on it; the foot of an object is followed down to a quarter of that.',
        low=1.0, high=20.0)
    objects: str = param(
        'all', 'Make a view of every object of a frame, the largest first (all), of the largest, '
        'or of the nearest to the sensor.', choices=('all', 'largest', 'nearest'))
    gap_m: float = param(
        0.01, 'Parts that stand on the plane closer together than this are one object.',
        unit='m', low=0.0, high=10.0)
    least_points: int = param(
        500, 'What has fewer points is no object but a speck.', low=1, high=1000000000)
    edge_deg: float = param(
        80.0, 'Surfaces seen flatter than this from their normal are depth edges: they part '
        'objects, and points that hang between are dropped.', unit='deg', low=45.0, high=89.9)
    most_points: int = param(
        0, 'Reduce a view of more points to about this number by averaging neighbours; 0 for '
        'no limit.', low=0, high=1000000000)


@dataclass(frozen=True, slots=True)
class PriorConfig(Group):
    """What is known of the station; used to find and to refuse poses, never to invent them."""

    plane: bool = param(
        False, 'The objects stand on the same foot in all views: poses must map the supporting '
        'plane of one view to that of the other.')
    axis: bool = param(
        False, 'The objects stand on a turntable before a fixed sensor: all poses turn about '
        'one axis, which is found from the data.')
    order: bool = param(
        False, 'The turntable turns one way and by less than half a turn from one view to the '
        "next (with 'axis').")
    step_deg: float = param(
        0.0, 'What the turntable turns by from one view to the next, in either direction (with '
        "'axis'); 0 if that is not known.", unit='deg', low=0.0, high=360.0)
    tilt_deg: float = param(
        10.0, 'Most that the pose of two views may tilt against plane or axis; when all views '
        'are refined together the rest is taken out.', unit='deg', low=0.1, high=90.0)
    distance_mr: float = param(
        8.0, 'Most that it may be off in height, or at the axis.',
        unit='mr', low=0.1, high=1000.0)
    turn_deg: float = param(
        5.0, 'Most that it may turn more or less than step_deg says.',
        unit='deg', low=0.1, high=90.0)
    fixed_frame: str = param(
        '', 'Frame of TF in which the objects stand still (the world, or a turntable whose turns '
        'TF tells): where TF knows the sensor in it at the time of a view, poses must agree with '
        'that. Empty: not used.')
    pose_deg: float = param(
        10.0, 'Most that the pose of two views may turn against the sensor poses in fixed_frame.',
        unit='deg', low=0.1, high=180.0)
    pose_m: float = param(
        0.05, 'Most that it may move the middle of the view against them.',
        unit='m', low=0.0001, high=1000.0)
    weight: float = param(
        3.0, 'Weight of plane and axis when all views are refined together, as a multiple of '
        "that of a view's matches.", low=0.0, high=1000.0)
    harm: float = param(
        1.25, 'Plane and axis are not used in refining an object whose residual they would '
        'raise by more than this factor.', low=1.0, high=100.0)
