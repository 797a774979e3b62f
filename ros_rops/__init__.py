# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Register unordered range views into one model per object (Guo et al. 2014)."""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from ros_rops.core.config import Config
    from ros_rops.core.types import RangeView, SensorModel, Status
    from ros_rops.pipeline.pair import register_pair
    from ros_rops.pipeline.session import Session

__version__ = '0.1.0'

__all__ = ['Config', 'RangeView', 'SensorModel', 'Session', 'Status', 'register_pair']

# Imported when first asked for: `import ros_rops` costs next to nothing.
_HOMES = {
    'Config': 'core.config',
    'RangeView': 'core.types',
    'SensorModel': 'core.types',
    'Session': 'pipeline.session',
    'Status': 'core.types',
    'register_pair': 'pipeline.pair',
}


def __getattr__(name: str) -> Any:
    """Import a public name from where it lives."""
    if name not in _HOMES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)
