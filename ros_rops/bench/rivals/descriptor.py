# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A rival descriptor in the engine's own pipeline: only the descriptors are exchanged."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.contest import Contestant, engine
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


def with_descriptor(
    descriptor: Descriptor, config: Config, *, threads: int = 0
) -> Contestant:
    """
    Return the engine as a contestant, its RoPS exchanged for another descriptor.

    Keypoints, frames, matching, search and verdict stay: what differs is the descriptor alone.
    """
    own = engine(config, threads=threads)

    def prepare(view: RangeView) -> PreparedView:
        prepared: PreparedView = own.prepare(view)
        surface = prepared.surface
        features = surface.features
        descriptors = descriptor.describe(
            prepared.mesh, features.indices, features.lrfs, surface.resolution, threads)
        exchanged = replace(features, descriptors=frozen(descriptors, np.float32))
        return replace(prepared, surface=replace(surface, features=exchanged))

    return Contestant(descriptor.name, prepare, own.register)
