# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a run folder's `poses.json` says."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
from pathlib import Path

import numpy as np
from ros_rops.bench.judgement import Placement
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats


@dataclass(frozen=True, slots=True)
class Run:
    """
    What `poses.json` of a run says.

    Parameters
    ----------
    units : str
    mesh_resolution : float
        In `units`.
    placements : mapping of str to Placement
        Placed views by name, poses in `units`.
    statuses : mapping of str to str
        Of all views, the ones not placed included.
    centroids : mapping of str to (3,) float64
        Mean of a view's points in its own frame, where the run states it.
    attempts : int or None
    """

    units: str
    mesh_resolution: float
    placements: Mapping[str, Placement]
    statuses: Mapping[str, str]
    centroids: Mapping[str, Floats]
    attempts: int | None


def read_run(run: Path | str) -> Run:
    """
    Read `poses.json` of a run folder, or the file itself.

    Raises
    ------
    InputError
        If it cannot be read or is not of that form; the text names the file and the fault.
    """
    path = Path(run)
    path = path / 'poses.json' if path.is_dir() else path
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
        placements = {
            str(view['name']): Placement(str(shape['id']), _matrix(view['T_object_view']))
            for shape in content['objects']
            for view in shape['views']
        }
        statuses = {str(view['name']): str(view['status']) for view in content['views']}
        centroids = {
            str(view['name']): np.array(view['centroid'], dtype=np.float64).reshape(3)
            for view in content['views']
            if view.get('centroid') is not None
        }
        attempts = content.get('attempts')
        return Run(
            str(content['units']), float(content['mesh_resolution'] or 0.0), placements,
            statuses, centroids, None if attempts is None else int(attempts))
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f'{path}: is not the poses.json of a run ({error!r})') from None


def _matrix(value: object) -> Floats:
    T = np.array(value, dtype=np.float64)
    if T.shape != (4, 4) or not np.isfinite(T).all():
        raise ValueError(f'T_object_view: expected a finite 4x4 matrix, got shape {T.shape}')
    return T


def match_names(run_names: Sequence[str], truth_names: Sequence[str]) -> dict[str, str]:
    """
    Find the truth's name of each of the run's names; those that fit none or several are left out.

    A name fits if it is the same, or if its last component is: then, if several of the truth's
    do, the set's name must be among the other components.
    """
    result = {}
    by_last: dict[str, list[str]] = {}
    for name in truth_names:
        by_last.setdefault(Path(name).name, []).append(name)
    for name in run_names:
        fitting = by_last.get(Path(name).name, [])
        if name in truth_names:
            fitting = [name]
        elif len(fitting) > 1:
            parents = Path(name).parent.parts
            fitting = [one for one in fitting if Path(one).parent.name in parents]
        if len(fitting) == 1:
            result[name] = fitting[0]
    return result
