# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A rival descriptor in the engine's own pipeline: only the descriptors are exchanged."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.contest import Contestant, engine
from ros_rops.core import rops as core_rops
from ros_rops.core.config import Config
from ros_rops.core.types import Floats, frozen, Ints, RangeMesh, RangeView
from ros_rops.pipeline.prepare import PreparedView


class Describe(Protocol):
    """What computes descriptors."""

    def __call__(
        self, mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int
    ) -> NDArray[np.float32]:
        """
        Describe vertices of a mesh.

        Parameters
        ----------
        mesh : RangeMesh
        indices : (K,) int32
            Keypoints.
        lrfs : (K, 3, 3) float64
            Frames of the keypoints, rows are the axes; the descriptor may leave them unused.
        unit : float
            Mesh resolution (mr).
        threads : int

        Returns
        -------
        (K, D) float32
            Compared by Euclidean distance.
        """


@dataclass(frozen=True, slots=True)
class Descriptor:
    """
    A local surface feature.

    Parameters
    ----------
    name : str
    source : str
        Where it was published, and whose implementation this is.
    describe : Describe
    missing : callable
        Why it cannot be had here (a library that is not installed), None where it can.
    """

    name: str
    source: str
    describe: Describe
    missing: Callable[[], str | None] = lambda: None


def rops(config: Config) -> Descriptor:
    """Return the engine's own descriptor, as configured, in the form of its rivals."""
    def describe(
        mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int
    ) -> NDArray[np.float32]:
        return core_rops.describe(
            mesh, indices, config.lrf, config.rops, lrfs=lrfs, resolution=unit, threads=threads,
        ).descriptors

    return Descriptor('RoPS', 'Guo et al. 2013; ours', describe)


def exchanged(
    prepared: PreparedView, descriptor: Descriptor, *, threads: int = 0
) -> PreparedView:
    """Return a prepared view with another descriptor; keypoints, frames and the rest stay."""
    surface = prepared.surface
    features = surface.features
    rows = descriptor.describe(
        prepared.mesh, features.indices, features.lrfs, surface.resolution, threads)
    features = replace(features, descriptors=frozen(rows, np.float32))
    return replace(prepared, surface=replace(surface, features=features))


def with_descriptor(
    descriptor: Descriptor, config: Config, *, threads: int = 0
) -> Contestant:
    """
    Return the engine as a contestant, its RoPS exchanged for another descriptor.

    Keypoints, frames, matching, search and verdict stay: what differs is the descriptor alone.
    """
    own = engine(config, threads=threads)

    def prepare(view: RangeView) -> PreparedView:
        return exchanged(own.prepare(view), descriptor, threads=threads)

    return Contestant(descriptor.name, prepare, own.register)
