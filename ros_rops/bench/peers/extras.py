# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What of the extra `bench` is not installed."""

from collections.abc import Sequence
import importlib.util

# Names to install by, of modules that have others.
PIP = {'kiss_matcher': 'kiss-matcher', 'small_gicp': 'small-gicp'}


def missing(who: str, needs: Sequence[str]) -> str | None:
    """Return why `who` cannot take part, a sentence; None where all modules are there."""
    absent = [name for name in needs if importlib.util.find_spec(name) is None]
    if not absent:
        return None
    names = ' and '.join(PIP.get(name, name) for name in absent)
    return f"{who}: {names} not installed (pip install 'ros_rops[bench]'), no comparison"


def open3d_missing() -> str | None:
    """Return why Open3D cannot take part, None where it can."""
    return missing('Open3D', ('open3d',))
