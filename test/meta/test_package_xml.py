# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""package.xml. Truth: REP 149 (format 3), and the imports of the code itself."""

import re
import sys
from xml.etree import ElementTree

from meta.tree import imports, name, python_files, ROOT
import pytest

# Packages of ROS, whose rosdep key is their name; pip has no part in them.
ROS = {
    'ament_flake8', 'ament_pep257', 'builtin_interfaces', 'diagnostic_msgs',
    'geometry_msgs', 'launch', 'launch_ros', 'lifecycle_msgs', 'rcl_interfaces', 'rclpy',
    'rosgraph_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs', 'tf2_msgs', 'visualization_msgs'}
# Import name -> rosdep key on Ubuntu 24.04; None where there is none.
KEYS = {
    **{package: package for package in ROS},
    'hypothesis': 'python3-hypothesis',
    'lz4': 'python3-lz4',
    'matplotlib': 'python3-matplotlib',
    'mcap': None,
    'mcap_ros2': None,
    'numpy': 'python3-numpy',
    'kiss_matcher': None,
    'open3d': None,
    'small_gicp': None,
    'PySide6': None,
    'pybind11': 'pybind11-dev',
    'pytest': 'python3-pytest',
    'rosbags': None,
    'scipy': 'python3-scipy',
    'skimage': 'python3-skimage',
    'setuptools': 'python3-setuptools',
    'trimesh': None,
    'yaml': 'python3-yaml',
    'zstandard': None,
}
# Import name -> name on the package index, where they differ.
INDEX_NAMES = {
    'mcap_ros2': 'mcap-ros2-support', 'skimage': 'scikit-image', 'yaml': 'pyyaml'}
OPTIONAL = {'kiss_matcher', 'open3d', 'small_gicp'}
OURS = ('ros_rops', 'msg_adapters', 'meta', 'oracle', 'property', 'reference', 'ros', 'unit')
# Brought by every ament_python build.
IMPLIED = {'python3-setuptools'}
# Loaded by name, not by an import statement.
BY_NAME = {'ament_flake8', 'ament_pep257'}


@pytest.fixture(scope='module')
def package():
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def _keys(package, *tags: str) -> set[str]:
    return {item.text for tag in tags for item in package.findall(tag)}


def _third_party(*rooms: str) -> dict[str, str]:
    """Import name -> a file that imports it."""
    found = {}
    for path in python_files(*rooms):
        for module in imports(path):
            top = module.partition('.')[0]
            local = (path.parent / f'{top}.py').exists() or (path.parent / top).is_dir()
            if top not in sys.stdlib_module_names and top not in OURS and not local:
                found[top] = name(path)
    return found


def test_format_3_with_the_required_tags_in_order(package):
    assert package.tag == 'package' and package.get('format') == '3'
    required = ['name', 'version', 'description', 'maintainer', 'license']
    assert [item.tag for item in package][:5] == required
    assert re.fullmatch(r'[a-z][a-z0-9_]+', package.findtext('name'))
    assert re.fullmatch(r'\d+\.\d+\.\d+', package.findtext('version'))
    assert re.fullmatch(r'[^@\s]+@[^@\s]+\.[a-z]+', package.find('maintainer').get('email'))
    assert package.findtext('license') == 'Apache-2.0'
    assert (ROOT / package.find('license').get('file')).is_file()
    assert package.findtext('export/build_type') == 'ament_python'


def test_only_tags_of_format_3(package):
    known = {
        'name', 'version', 'description', 'maintainer', 'license', 'url', 'author', 'depend',
        'build_depend', 'buildtool_depend', 'exec_depend', 'test_depend', 'export'}
    assert {item.tag for item in package} <= known


def test_version_is_that_of_setup_py(package):
    setup = (ROOT / 'setup.py').read_text(encoding='utf-8')
    assert f"version='{package.findtext('version')}'" in setup


def test_every_import_of_the_package_is_declared(package):
    declared = _keys(package, 'exec_depend', 'depend')
    text = (ROOT / 'package.xml').read_text(encoding='utf-8')
    missing = {
        module: path for module, path in _third_party('ros_rops', 'msg_adapters', 'launch').items()
        if module not in KEYS
        or (KEYS[module] is None and not re.search(rf'^ +{module} ', text, re.MULTILINE))
        or (KEYS[module] is not None and KEYS[module] not in declared)}
    assert missing == {}


def test_every_import_of_the_tests_is_declared(package):
    declared = _keys(package, 'exec_depend', 'depend', 'test_depend', 'build_depend') | IMPLIED
    missing = {
        module: path for module, path in _third_party('test').items()
        if module not in KEYS or (KEYS[module] is not None and KEYS[module] not in declared)}
    assert missing == {}


def test_pip_installs_what_is_imported_and_nothing_else():
    setup = (ROOT / 'setup.py').read_text(encoding='utf-8')
    listed = re.search(r'install_requires=\[(.*?)\]', setup, re.DOTALL).group(1)
    required = set(re.findall(r"'([a-z0-9-]+)>=[^']*,<[^']*'", listed))
    imported = set(_third_party('ros_rops', 'msg_adapters')) - OPTIONAL - ROS
    assert required == {INDEX_NAMES.get(module, module) for module in imported}
    assert listed.count("'") == 2 * len(required), 'a requirement is no range'


def test_every_declared_key_is_imported(package):
    runtime = {KEYS.get(module) for module in _third_party('ros_rops', 'msg_adapters', 'launch')}
    tests = {KEYS.get(module) for module in _third_party('test')} | BY_NAME
    assert _keys(package, 'exec_depend', 'depend') - runtime == set()
    assert _keys(package, 'test_depend') - tests == set()
