# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Make the demo recording: about 20 mixed views of two procedural objects.

Run `python -m ros_rops.recordings.make_demo bags`; the seed is a constant below.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import sys

import numpy as np

from ros_rops.recordings.depth_noise import DepthNoise
from ros_rops.recordings.mcap_files import write_mcap
from ros_rops.recordings.procedural import mesh_of, OBJECTS
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.simulate_models import paint
from ros_rops.recordings.synthetic import (
    Capture, hand_held_poses, Model, render_view)
from ros_rops.recordings.writers import write_poses

SEED = 20261122
VIEWS_PER_OBJECT = 10
TOPIC = '/camera/depth/points'
FRAME = 'camera_depth_optical_frame'
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 1_000_000_000
CAMERA = Camera(320, 240, 320.0, 320.0, 159.5, 119.5)
TINTS = {'blob': (196, 120, 72), 'bracket': (96, 132, 168)}


def demo_models() -> list[Model]:
    """Return the two objects as meshes."""
    models = []
    for name, make in OBJECTS.items():
        vertices, faces = mesh_of(make())
        models.append(Model(vertices, faces, paint(vertices, TINTS[name]), name))
    return models


def demo_captures(models: Sequence[Model]) -> list[Capture]:
    """Return the views in their shuffled order, stamped and named as the recording names them."""
    rng = np.random.default_rng(SEED)
    captures = []
    # One operator, one distance: the larger object decides it for both.
    radius = max(model.radius for model in models)
    for model in models:
        for T in hand_held_poses(model.middle, radius, VIEWS_PER_OBJECT, rng):
            captures.append(render_view(model, T, CAMERA, noise=DepthNoise(), rng=rng))
    order = rng.permutation(len(captures))
    return [_stamped(captures[k], START_NS + n * PERIOD_NS) for n, k in enumerate(order)]


def _stamped(capture: Capture, stamp_ns: int) -> Capture:
    name = f'{TOPIC}@{stamp_ns}'
    return replace(
        capture, view=replace(capture.view, name=name, stamp_ns=stamp_ns, frame_id=FRAME))


def write_demo(folder: Path) -> None:
    """
    Write `demo.mcap` and `demo_poses.json` into a folder.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    captures = demo_captures(demo_models())
    write_mcap(folder / 'demo.mcap', captures, topic=TOPIC)
    write_poses(
        folder / 'demo_poses.json',
        {c.view.name: c.T_world_view for c in captures},
        units='m', reference='exact', objects={c.view.name: c.object_name for c in captures},
        note=f'Exact: rendered by ros_rops.recordings.make_demo, seed {SEED}.',
    )


if __name__ == '__main__':
    write_demo(Path(sys.argv[1] if len(sys.argv) > 1 else 'bags'))
