# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whether what the parameters ask for is installed; known before hours of work."""

import importlib.util

from ros_rops.core.errors import ParameterError
from ros_rops.core.groups_model import ModelConfig


def check_libraries(config: ModelConfig) -> None:
    """
    See that the library is there that makes the surface; it is not loaded.

    Raises
    ------
    ParameterError
        If `model.surface` is poisson, and Open3D is not installed.
    """
    if config.surface == 'poisson' and importlib.util.find_spec('open3d') is None:
        raise ParameterError(
            'model.surface: poisson needs Open3D, which is not installed: '
            "pip install 'ros_rops[poisson]', or take volume")
