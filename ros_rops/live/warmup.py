# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The first registration of a process takes longer than others: make it before views come."""

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.pipeline.session import Session

SIDE = 40


def warm_up(config: Config, threads: int) -> None:
    """Register two small views of a bumpy surface, so that all is loaded that will be used."""
    session = Session(config, threads=threads)
    for number in range(2):
        session.add(_view(number))
    session.finish()


def _view(number: int) -> RangeView:
    x, y = np.meshgrid(np.arange(SIDE) / SIDE, np.arange(SIDE) / SIDE)
    z = 2.0 + 0.1 * np.sin(7.0 * x + 0.5 * number) * np.cos(9.0 * y) + 0.05 * np.sin(23.0 * x * y)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    grid = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE, SIDE)
    return RangeView(str(number), points, grid, SensorModel('pinhole'), units='m')
