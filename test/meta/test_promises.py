# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Promises that the repository makes about itself. Truth: the rules, written down here."""

import ast
import importlib.util
import os
import re
import subprocess
import sys

from meta.tree import files, imports, name, python_files, ROOT, syntax
import pytest

LONGEST_FILE = 300
# Built from pieces so that this file passes its own test.
MACHINE = re.compile('|'.join([
    r'(?<![\w./])/' + r'(work|root|farm|home)/\w', r'(?<![\w./])/' + 'tmp/h' + '_',
    'pypi' + r'\.org', 'pythonhosted' + r'\.org']))


def _generate():
    spec = importlib.util.spec_from_file_location('generate', ROOT / '.ci' / 'generate.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize('path', files('.py', '.cpp', '.hpp'), ids=name)
def test_file_is_short(path):
    assert len(path.read_text(encoding='utf-8').splitlines()) <= LONGEST_FILE


def test_no_paths_of_one_machine():
    for path in files():
        try:
            text = path.read_text(encoding='utf-8')
        except UnicodeDecodeError:
            continue
        found = MACHINE.search(text)
        assert found is None, f'{name(path)}: {found.group()}'


def test_no_three_argument_getattr_in_core_and_pipeline():
    for path in python_files('ros_rops/core', 'ros_rops/kernels', 'ros_rops/pipeline'):
        for node in ast.walk(syntax(path)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id != 'getattr' or len(node.args) < 3, (
                    f'{name(path)}:{node.lineno}')


def test_raised_errors_are_of_our_tree():
    tree = syntax(ROOT / 'ros_rops' / 'core' / 'errors.py')
    ours = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    for path in python_files('ros_rops/core', 'ros_rops/kernels', 'ros_rops/pipeline'):
        for node in ast.walk(syntax(path)):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
                assert node.exc.func.id in ours, f'{name(path)}:{node.lineno}'


def test_every_error_class_is_raised_in_a_test():
    tree = syntax(ROOT / 'ros_rops' / 'core' / 'errors.py')
    ours = {node.name for node in tree.body if isinstance(node, ast.ClassDef)} - {'RopsError'}
    raised = {
        node.exc.func.id
        for path in python_files('ros_rops', 'msg_adapters')
        for node in ast.walk(syntax(path))
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call)
        and isinstance(node.exc.func, ast.Name)}
    tests = '\n'.join(path.read_text(encoding='utf-8') for path in python_files('test'))
    for error in sorted(ours & raised):
        assert re.search(rf'raises\(\s*\(?[^)]*\b{error}\b', tests), f'{error} is never tripped'


def test_default_yaml_is_generated():
    text = (ROOT / 'config' / 'default.yaml').read_text(encoding='utf-8')
    assert text == _generate().default_yaml(), 'run `make generate`'


def test_readme_table_is_generated():
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    assert text == _generate().readme(text), 'run `make generate`'


def test_readme_commands_exist():
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    makefile = (ROOT / 'Makefile').read_text(encoding='utf-8')
    blocks = '\n'.join(re.findall(r'```sh\n(.*?)```', text, re.DOTALL))
    targets = re.findall(r'^make (\w+)', blocks, re.MULTILINE)
    assert {'demo', 'test'} <= set(targets)
    for target in targets:
        assert re.search(rf'^{target}:', makefile, re.MULTILINE), target
    for verb in re.findall(r'^rops ([\w-]+)', blocks, re.MULTILINE):
        assert (ROOT / 'ros_rops' / 'cli' / f'{verb.replace("-", "_")}.py').is_file(), verb


def _seconds(statement: str) -> float:
    code = f'import time; t = time.perf_counter(); {statement}; print(time.perf_counter() - t)'
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    return float(run.stdout)


@pytest.mark.alone
def test_import_is_quick():
    # A ratio of two figures of this moment and machine; numpy takes about 0.1 s when idle.
    numpy = min(_seconds('import numpy') for _ in range(3))
    ours = min(_seconds('import ros_rops') for _ in range(3))
    assert ours < 3 * numpy


def test_import_loads_nothing_heavy():
    heavy = "{'open3d', 'matplotlib', 'rclpy', 'mcap', 'rosbags', 'pandas', 'sklearn'}"
    code = f'import sys, ros_rops; print(sorted({heavy} & set(sys.modules)))'
    # ROS's wheels run code when Python starts; -S -E would hide them and our package alike.
    before = f'import sys; print(sorted({heavy} & set(sys.modules)))'
    outputs = [
        subprocess.run(
            [sys.executable, '-c', text], capture_output=True, text=True, check=True,
            env={**os.environ, 'PYTHONPATH': str(ROOT)}).stdout
        for text in (before, code)]
    assert outputs[0] == outputs[1]


def test_heavy_imports_stay_inside_functions():
    for path in python_files('ros_rops', 'msg_adapters'):
        top = {
            alias.name.partition('.')[0] for node in syntax(path).body
            if isinstance(node, ast.Import) for alias in node.names} | {
            (node.module or '').partition('.')[0] for node in syntax(path).body
            if isinstance(node, ast.ImportFrom)}
        assert not top & {'open3d', 'matplotlib'}, name(path)
    assert any('numpy' in imports(path) for path in python_files('ros_rops'))
