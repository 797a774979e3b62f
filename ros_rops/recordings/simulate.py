# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Simulated captures of meshes, written as a depth camera's driver would, with their exact poses.

Frames: `world`, below it `turntable` (z up, on its surface) and the camera, on `/tf`; below
`turntable` one frame an object, on `/tf_static`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import os
from pathlib import Path
from typing import Literal

import numpy as np

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Floats
from ros_rops.recordings.cdr import Transform
from ros_rops.recordings.depth_noise import DepthNoise
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.mcap_writer import McapStream
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.scene import look, Picture, Placed
from ros_rops.recordings.station import place, Plan, Shot, shots, START_NS
from ros_rops.recordings.synthetic import Model
from ros_rops.recordings.writers import write_poses

FRAME = 'camera_depth_optical_frame'
POINTS = '/camera/depth/points'
DEPTH, DEPTH_INFO = '/camera/depth/image_rect_raw', '/camera/depth/camera_info'
COLOR, COLOR_INFO = '/camera/color/image_raw', '/camera/color/camera_info'
Output = Literal['points', 'depth', 'depth-float']


@dataclass(frozen=True, slots=True)
class Sensor:
    """
    The camera and what it delivers.

    Parameters
    ----------
    camera : Camera
    output : {'points', 'depth', 'depth-float'}
        Organized PointCloud2; Image 16UC1 in millimetres; Image 32FC1 in metres.
    noise : DepthNoise or None
    table : float or None
        Radius of a table in metres, 0 for three times what stands on it; None for no table.
    """

    camera: Camera
    output: Output = 'points'
    noise: DepthNoise | None = None
    table: float | None = None

    @property
    def topic(self) -> str:
        """Return the topic that the frames are named after."""
        return POINTS if self.output == 'points' else DEPTH


def pinhole(width: int, height: int, fov_deg: float) -> Camera:
    """
    Return a camera with square pixels, its centre in the middle.

    Parameters
    ----------
    width, height : int
        In pixels.
    fov_deg : float
        Horizontal field of view.

    Raises
    ------
    ParameterError
        If there is no such camera.
    """
    if not (1 <= width <= 10_000 and 1 <= height <= 10_000):
        raise ParameterError(f'image: must measure 1-10000 pixels, got {width}x{height}')
    if not 0 < fov_deg < 170:
        raise ParameterError(f'fov: must lie in 0-170 degrees, got {fov_deg}')
    focal = width / 2 / np.tan(np.deg2rad(fov_deg) / 2)
    return Camera(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def poses_path(path: str | os.PathLike[str]) -> Path:
    """Return where the poses of a recording lie: `X_poses.json` beside `X.mcap`."""
    path = Path(path)
    return path.with_name(f'{path.stem}_poses.json')


def simulate(
    models: Sequence[Model], path: str | os.PathLike[str], plan: Plan, sensor: Sensor, *,
    seed: int = 0, note: str = '', tell: Callable[[str], None] | None = None,
) -> int:
    """
    Render a capture, write the recording and its poses; return the number of frames.

    The same arguments give the same bytes.

    Parameters
    ----------
    models : sequence of Model
        In metres, z up, their names distinct.
    path : path
        Of the recording; `poses_path` says where the poses go.
    plan : Plan
    sensor : Sensor
    seed : int
    note : str
        Goes into the poses' file.
    tell : callable or None
        Told the name of each frame when it is written.

    Raises
    ------
    InputError
        If a file cannot be written.
    ParameterError
        If there is no model, or the seed is negative.
    """
    if not models:
        raise ParameterError('models: none given')
    if seed < 0:
        raise ParameterError(f'seed: must be at least 0, got {seed}')
    placed = place(models, together=plan.together, rng=np.random.default_rng([seed, 0]))
    order = shots(placed, plan, np.random.default_rng([seed, 1]), above=sensor.table is not None)
    radius = _table_radius(placed, sensor.table)
    with create_mcap(path) as mcap:
        mcap.add_transforms(
            [Transform(p.T_turntable_object, 'turntable', p.model.name) for p in placed],
            stamp_ns=START_NS, topic='/tf_static')
        for number, shot in enumerate(order):
            picture = look(
                [placed[k] for k in shot.objects],
                np.linalg.inv(shot.T_world_camera) @ shot.T_world_turntable, sensor.camera,
                table_radius=radius, noise=sensor.noise,
                rng=np.random.default_rng([seed, 2, number]))
            _write(mcap, picture, shot, sensor)
            if tell is not None:
                tell(f'{sensor.topic}@{shot.stamp_ns}')
    write_truth(path, placed, order, sensor.topic, note)
    return len(order)


def _table_radius(placed: Sequence[Placed], asked: float | None) -> float:
    if asked is None:
        return 0.0
    if not 0 <= asked < np.inf:
        raise ParameterError(f'table: the radius must be at least 0, got {asked}')
    if asked:
        return asked
    reach = [
        np.hypot(*(p.model.vertices @ p.T_turntable_object[:3, :3].T
                   + p.T_turntable_object[:3, 3])[:, :2].T).max() for p in placed]
    return 3.0 * float(max(reach))


def _write(mcap: McapStream, picture: Picture, shot: Shot, sensor: Sensor) -> None:
    stamp, camera = shot.stamp_ns, sensor.camera
    mcap.add_transforms([
        Transform(shot.T_world_turntable, 'world', 'turntable'),
        Transform(shot.T_world_camera, 'world', FRAME)], stamp_ns=stamp)
    if sensor.output == 'points':
        points = (picture.depth[..., None] * camera.rays()).astype(np.float32)
        mcap.add_cloud(
            points, topic=POINTS, stamp_ns=stamp, frame_id=FRAME, colors=picture.colors)
        return
    if picture.colors is not None:
        mcap.add_camera_info(camera, topic=COLOR_INFO, stamp_ns=stamp, frame_id=FRAME)
        mcap.add_image(picture.colors, 'rgb8', topic=COLOR, stamp_ns=stamp, frame_id=FRAME)
    depth = picture.depth.astype(np.float32)
    if sensor.output == 'depth':
        whole = np.rint(np.nan_to_num(picture.depth * 1000.0))
        depth = np.where(whole > 65535, 0, whole).astype(np.uint16)
    mcap.add_depth(
        depth, camera, topic=DEPTH, info_topic=DEPTH_INFO, stamp_ns=stamp, frame_id=FRAME)


def write_truth(
    path: str | os.PathLike[str], placed: Sequence[Placed], order: Sequence[Shot], topic: str,
    note: str,
) -> None:
    """
    Write the exact poses beside a recording, in the form of `reference_poses.json`.

    The world of a frame is the object's own frame, or that of the turntable where several
    objects stand on it: `centres` then tells where (turntable's frame).

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    poses: dict[str, Floats] = {}
    objects: dict[str, str] = {}
    for shot in order:
        name = f'{topic}@{shot.stamp_ns}'
        poses[name] = np.linalg.inv(shot.T_world_turntable) @ shot.T_world_camera
        if len(shot.objects) == 1:
            one = placed[shot.objects[0]]
            poses[name] = np.linalg.inv(one.T_turntable_object) @ poses[name]
            objects[name] = one.model.name
    together = not objects
    centres = {p.model.name: _centre(p) for p in placed} if together else None
    write_poses(poses_path(path), poses, units='m', reference='exact', objects=objects,
                centres=centres, note=note)


def _centre(placed: Placed) -> Floats:
    T = placed.T_turntable_object
    centre: Floats = T[:3, :3] @ placed.model.middle + T[:3, 3]
    return centre
