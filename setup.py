# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Build the package for pip and for colcon (ament_python)."""

from pathlib import Path

from pybind11.setup_helpers import Pybind11Extension
from setuptools import find_packages, setup

PACKAGE = 'ros_rops'
ROOT = Path(__file__).resolve().parent

# Absolute paths: colcon's --symlink-install builds from another directory.
kernels = Pybind11Extension(
    f'{PACKAGE}.kernels._kernels',
    sorted(str(path) for path in (ROOT / PACKAGE / 'kernels' / 'src').glob('*.cpp')),
    include_dirs=[str(ROOT / PACKAGE / 'kernels' / 'src')],
    cxx_std=17,
    extra_compile_args=['-O3', '-ffp-contract=off', '-pthread'],
    extra_link_args=['-pthread'],
)

setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(include=[f'{PACKAGE}*', 'msg_adapters*']),
    ext_modules=[kernels],
)
