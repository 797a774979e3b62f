# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The repository as data, for the tests that check its promises."""

import ast
from collections.abc import Iterator
import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Made by tools, never by hand; the rest of the tree is ours.
_MADE = {'build', 'install', 'log', 'dist', 'runs', '__pycache__'}


def files(*suffixes: str, under: str = '.') -> list[Path]:
    """Return our files with one of `suffixes` (all when none is given), sorted."""
    found = []
    for folder, folders, names in os.walk(ROOT / under):
        folders[:] = [
            name for name in folders if name not in _MADE
            and (not name.startswith('.') or name == '.ci') and not name.endswith('.egg-info')]
        found += [Path(folder) / name for name in names]
    return sorted(
        path for path in found
        if path.suffix not in ('.so', '.pyc') and (not suffixes or path.suffix in suffixes))


def python_files(*rooms: str) -> list[Path]:
    """Return our Python files in `rooms`, which are folders below the root."""
    return [path for room in rooms if (ROOT / room).is_dir() for path in files('.py', under=room)]


def syntax(path: Path) -> ast.Module:
    """Return the parsed file."""
    return ast.parse(path.read_text(encoding='utf-8'), str(path))


def imports(path: Path) -> Iterator[str]:
    """Yield the dotted name of every module that the file imports, at any depth."""
    for node in ast.walk(syntax(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                package = path.relative_to(ROOT).parent.parts
                package = package[:len(package) - node.level + 1]
                base = '.'.join([*package, base] if base else package)
            yield base
            # `from ros_rops import kernels` imports a room too.
            if base == 'ros_rops':
                yield from (f'{base}.{alias.name}' for alias in node.names)


def name(path: Path) -> str:
    """Return the file's path below the root, as tests' ids."""
    return path.relative_to(ROOT).as_posix()
