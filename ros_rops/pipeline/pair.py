# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Two views, one answer."""

from ros_rops.core.config import Config
from ros_rops.core.pair_result import PairResult
from ros_rops.core.pairwise import register
from ros_rops.core.types import RangeView
from ros_rops.pipeline.prepare import prepare
from ros_rops.pipeline.units import in_units


def register_pair(
    source: RangeView, target: RangeView, config: Config | None = None, *, threads: int = 0
) -> PairResult:
    """
    Find the pose of one range view in the frame of another (Guo et al. 2014, III).

    Parameters
    ----------
    source, target : RangeView
        In any pose; points (N, 3) in metres or millimetres as their `units` say. The source is
        converted to the units of the target.
    config : Config, optional
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    PairResult
        `T_target_source` (4, 4) with p_target = T_target_source p_source, in the target's units,
        if `status` is PLACED; else None, the status AMBIGUOUS or REFUSED, and the reason.

    Raises
    ------
    ViewError
        If a view holds too little to register (empty, two points), or stray points.

    Examples
    --------
    >>> from ros_rops import register_pair
    >>> from ros_rops.recordings import read_view
    >>> result = register_pair(read_view('a.ply'), read_view('b.ply'))  # doctest: +SKIP
    >>> result.status, result.reason  # doctest: +SKIP
    """
    config = config or Config()
    there = prepare(target, config, threads=threads)
    here = prepare(
        in_units(source, target.units), config, resolution=there.surface.resolution,
        threads=threads)
    return register(here.surface, there.surface, config, threads=threads)
