# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whole MCAP files: there when they are finished, or not at all."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
import os
from pathlib import Path

import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.recordings import cdr
from ros_rops.recordings.mcap_writer import Keep, McapStream
from ros_rops.recordings.synthetic import Capture
from ros_rops.recordings.view_facts import organized

POSE_TOPIC = '/exact_poses'
"""Not /tf: one camera frame below two objects would be no tree."""


@contextmanager
def create_mcap(
    path: str | os.PathLike[str], *, keep: Keep = 'buffered', compressed: bool = True
) -> Iterator[McapStream]:
    """
    Open a recording for writing, as a context: its value is the `McapStream`.

    The file lies beside its place until it is finished; an exception inside leaves nothing behind.

    Parameters
    ----------
    path : path
        Replaced if it exists.
    keep, compressed
        As for `McapStream`.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    target = Path(path)
    with _saying(path):
        device = target.exists() and not target.is_file()  # a pipe, or somebody's folder
        part = target if device else target.with_name(target.name + '.part')
        stream = part.open('wb')
    try:
        mcap = McapStream(stream, name=str(path), keep=keep, compressed=compressed)
        yield mcap
        mcap.finish()
        with _saying(path):
            stream.close()
            if not device:
                part.replace(target)
    finally:
        with suppress(OSError):
            stream.close()
        if not device:
            with suppress(OSError):
                part.unlink(missing_ok=True)


@contextmanager
def _saying(path: str | os.PathLike[str]) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None


def write_mcap(
    path: str | os.PathLike[str], captures: Sequence[Capture], *, topic: str = '/points'
) -> None:
    """
    Write a recording as a camera's driver would: float32 clouds, their poses on `/exact_poses`.

    Parameters
    ----------
    path : path
    captures : sequence of Capture
        In the order of their `stamp_ns`, which also is the log time.
    topic : str
        Of the clouds.

    Raises
    ------
    InputError
        If a view has no stamp, or the file cannot be written.
    """
    with create_mcap(path) as mcap:
        for capture in captures:
            view = capture.view
            if view.stamp_ns is None:
                raise InputError(f'{path}: view {view.name!r} has no stamp')
            pose = cdr.Transform(
                capture.T_world_view, capture.object_name or 'world', view.frame_id)
            mcap.add_transforms([pose], stamp_ns=view.stamp_ns, topic=POSE_TOPIC)
            points, colors = organized(view)
            mcap.add_cloud(
                points.astype(np.float32), topic=topic, stamp_ns=view.stamp_ns,
                frame_id=view.frame_id, colors=colors)
