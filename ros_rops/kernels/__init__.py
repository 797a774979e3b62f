# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The few loops that must be fast: C++17 sources and their typed Python faces."""

from ros_rops.core.errors import KernelMissingError

try:
    from ros_rops.kernels import _kernels
except ImportError as error:
    raise KernelMissingError(
        f'the C++ kernels are not built, or for another Python ({error}): run `pip install .`, or '
        '`python setup.py build_ext --inplace`, in the source tree of ros_rops') from error

__all__ = ['_kernels']
