# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A rival estimator of the transformation: from matched features to one coarse pose (III-C)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.hypotheses import Matched
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats


@dataclass(frozen=True, slots=True)
class Estimator:
    """
    A way from correspondences to a transformation.

    Parameters
    ----------
    name : str
    source : str
        Where it was published.
    estimate : callable
        (source, target, pairs, config, rng) to `T_target_source` (4, 4), None without one.
    """

    name: str
    source: str
    estimate: Callable[
        [Surface, Surface, Matched, Config, np.random.Generator], Floats | None]
