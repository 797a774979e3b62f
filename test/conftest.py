# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The package under test is one whose kernels are built: this tree, or what colcon installed."""

from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]

# `python -m pytest`, which `colcon test` runs, puts the tree before all else.
if not any((ROOT / 'ros_rops' / 'kernels').glob('_kernels.*.so')):
    sys.path[:] = [folder for folder in sys.path if Path(folder).resolve() != ROOT]
