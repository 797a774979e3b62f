# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Descriptors of the Point Cloud Library, through a small program of ours.

PCL has no Python package; `pcl_features.cpp` beside this file is compiled when it is first asked
for, into the user's cache folder, and talks through its standard streams.
"""

from dataclasses import dataclass
from functools import cache
import hashlib
import os
from pathlib import Path
import shutil
import subprocess
import tempfile

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats, Ints, RangeMesh

SOURCE = Path(__file__).with_name('pcl_features.cpp')
PACKAGE = 'pcl_features'
FLAGS = ('-std=c++17', '-O2', '-DNDEBUG', '-fopenmp', '-Wl,--as-needed')
NAMES = ('spin', 'shot', 'usc', 'fpfh', 'rops')


@dataclass(frozen=True, slots=True)
class PclFeatures:
    """Descriptors (K, D) float32 of K vertices, and the seconds that PCL took for them."""

    descriptors: NDArray[np.float32]
    seconds: float


def pcl_missing() -> str | None:
    """Return why PCL's descriptors cannot be had here, None where they can."""
    try:
        program()
    except InputError as error:
        return str(error)
    return None


@cache
def program() -> Path:
    """
    Compile the program, unless that was done before.

    Raises
    ------
    InputError
        If there is no compiler or no PCL, or the compiler refuses.
    """
    for tool in ('g++', 'pkg-config'):
        if shutil.which(tool) is None:
            raise InputError(
                f'{tool} is not installed (apt install g++ pkg-config libpcl-dev): no PCL')
    version = subprocess.run(
        ['pkg-config', '--modversion', PACKAGE], capture_output=True, text=True, check=False)
    if version.returncode:
        raise InputError('PCL is not installed (apt install libpcl-dev)')
    what = SOURCE.read_bytes() + f'{version.stdout}{FLAGS}'.encode()
    path = cache_folder() / f'{PACKAGE}-{hashlib.sha256(what).hexdigest()[:16]}'
    if not path.exists():
        _compile(path)
    return path


def cache_folder() -> Path:
    """Return the user's folder for what can be made again."""
    home = os.environ.get('XDG_CACHE_HOME')
    return (Path(home) if home else Path.home() / '.cache') / 'ros_rops'


def _compile(path: Path) -> None:
    flags = subprocess.run(
        ['pkg-config', '--cflags', '--libs', PACKAGE], capture_output=True, text=True,
        check=True).stdout.split()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            made = Path(folder) / path.name
            done = subprocess.run(
                ['g++', *FLAGS, str(SOURCE), '-o', str(made), *flags],
                capture_output=True, text=True, check=False)
            if done.returncode:
                lines = [line for line in done.stderr.splitlines() if 'error' in line]
                raise InputError(f'{SOURCE.name} does not compile: {" ".join(lines[:1])}')
            made.replace(path)  # at once: another process may look for it
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None


def pcl_features(
    name: str, mesh: RangeMesh, indices: Ints, lrfs: Floats, radius: float, unit: float,
    *, threads: int = 1,
) -> PclFeatures:
    """
    Describe vertices by PCL; vertices without a face do not count.

    Parameters
    ----------
    name : {'spin', 'shot', 'usc', 'fpfh', 'rops'}
    mesh : RangeMesh
    indices : (K,) int32
        Vertices with a face.
    lrfs : (K, 3, 3) float64
        Frames, which `shot` and `usc` use.
    radius : float
        Of the support, in the mesh's units.
    unit : float
        Mesh resolution: PCL works in float32, and in this unit about the mean of the points.
    threads : int
        0 takes all cores; `spin`, `usc` and `rops` take one.

    Returns
    -------
    PclFeatures
        Rows of zeros where PCL gives NaN.

    Raises
    ------
    InputError
        If the program cannot be had, or refuses.
    """
    done = subprocess.run(
        [str(program()), name, repr(float(radius / unit)), str(threads)],
        input=_packed(mesh, indices, lrfs, unit), capture_output=True, check=False)
    if done.returncode:
        said = done.stderr.decode(errors='replace').strip().splitlines()
        raise InputError(f'PCL {name}: {said[-1] if said else f"ended by {done.returncode}"}')
    rows, columns = np.frombuffer(done.stdout, np.int32, 2)
    seconds = float(np.frombuffer(done.stdout, np.float64, 1, offset=8)[0])
    found = np.frombuffer(done.stdout, np.float32, rows * columns, offset=16)
    return PclFeatures(np.nan_to_num(found.reshape(rows, columns)), seconds)


def _packed(mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float) -> bytes:
    used = mesh.normals.any(axis=1)
    rank = np.cumsum(used) - 1
    points = mesh.vertices[used]
    parts = (
        np.array([len(points), len(mesh.faces), len(indices)], np.int32),
        ((points - points.mean(axis=0)) / unit).astype(np.float32),
        mesh.normals[used].astype(np.float32),
        rank[mesh.faces].astype(np.int32), rank[indices].astype(np.int32),
        lrfs.astype(np.float32))
    return b''.join(part.tobytes() for part in parts)
