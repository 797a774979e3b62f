# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Time of the frames and descriptors per keypoint, neighbour search included."""

from time import perf_counter

from ros_rops.core.config import Config
from ros_rops.core.rops import describe
from ros_rops.core.types import Ints, RangeMesh

Measurement = dict[str, int | float | str]


def measure_descriptor(
    mesh: RangeMesh,
    keypoints: Ints,
    config: Config,
    threads: int = 1,
    *,
    rounds: int = 5,
) -> Measurement:
    """
    Measure `describe`: grid over the mesh, supports, frames and RoPS, all of them each time.

    Parameters
    ----------
    mesh : RangeMesh
    keypoints : (K,) int32
        Vertices to describe; at least one.
    config : Config
        Groups `lrf` and `rops`.
    threads : int
        0 takes all cores.
    rounds : int
        The fastest of so many runs counts, after one to warm up.

    Returns
    -------
    dict
        "keypoints", "threads", "radius_mr", "lrf", "convention", "ms_per_keypoint".
    """
    seconds = [
        _seconds(mesh, keypoints, config, threads) for _ in range(rounds + 1)
    ][1:]
    return {
        'keypoints': len(keypoints),
        'threads': threads,
        'radius_mr': config.rops.radius_mr,
        'lrf': config.lrf.method,
        'convention': config.rops.convention,
        'ms_per_keypoint': 1e3 * min(seconds) / len(keypoints),
    }


def _seconds(mesh: RangeMesh, keypoints: Ints, config: Config, threads: int) -> float:
    begin = perf_counter()
    describe(mesh, keypoints, config.lrf, config.rops, threads=threads)
    return perf_counter() - begin
