# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Who takes part in the contest on pairs, and what each needs."""

from collections.abc import Callable
from dataclasses import dataclass

from ros_rops.bench.contest import Contestant, engine
from ros_rops.bench.peers import kiss, open3d_pairs
from ros_rops.core.config import Config


@dataclass(frozen=True, slots=True)
class Peer:
    """
    A program that registers pairs.

    Parameters
    ----------
    name : str
    needs : tuple of str
        Modules that it cannot do without.
    make : callable
        (dres, config, threads) to a contestant; called where the modules are.
    """

    name: str
    needs: tuple[str, ...]
    make: Callable[[float, Config, int], Contestant]


OURS = 'ros_rops'
_ENGINE = Peer(OURS, (), lambda dres, config, threads: engine(config, threads=threads))
_RANSAC = Peer(
    'Open3D FPFH + RANSAC + ICP', ('open3d',),
    lambda dres, config, threads: open3d_pairs.open3d_contestant(
        'open3d ransac', dres, open3d_pairs.ransac, plane=False))
_RANSAC_PLANE = Peer(
    'Open3D FPFH + RANSAC + point-to-plane ICP', ('open3d',),
    lambda dres, config, threads: open3d_pairs.open3d_contestant(
        'open3d ransac plane', dres, open3d_pairs.ransac, plane=True))
_FGR = Peer(
    'Open3D FPFH + FGR + ICP', ('open3d',),
    lambda dres, config, threads: open3d_pairs.open3d_contestant(
        'open3d fgr', dres, open3d_pairs.fast_global, plane=False))
_KISS_GICP = Peer(
    'KISS-Matcher + small_gicp', ('kiss_matcher', 'small_gicp'),
    lambda dres, config, threads: kiss.with_small_gicp(
        'kiss gicp', dres, threads))
_KISS_ICP = Peer(
    'KISS-Matcher + ICP', ('kiss_matcher', 'open3d'),
    lambda dres, config, threads: kiss.with_open3d_icp('kiss icp', dres))

ROSTER: dict[str, Peer] = {
    peer.name: peer for peer in (_ENGINE, _RANSAC, _RANSAC_PLANE, _FGR, _KISS_GICP, _KISS_ICP)}
