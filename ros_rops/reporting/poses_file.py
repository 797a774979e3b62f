# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`poses.json` read back."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from ros_rops.core.errors import InputError
from ros_rops.recordings.files import read_bytes


def read_document(path: Path) -> dict[str, Any]:
    """
    Read a `poses.json`.

    Raises
    ------
    InputError
        If it cannot be read, or is none; the text says which.
    """
    try:
        document: dict[str, Any] = json.loads(read_bytes(path))
        for shape in document['objects']:
            int(shape['id'])
            for view in shape['views']:
                T = np.array(view['T_object_view'], np.float64)
                if T.shape != (4, 4) or not np.isfinite(T).all():
                    raise ValueError(f'the pose of {view["name"]!r} is no 4x4 matrix of numbers')
        known = {view['name'] for view in document['views']}
        missing = {v['name'] for shape in document['objects'] for v in shape['views']} - known
        if missing or document['units'] not in ('m', 'mm', 'unknown', None):
            raise ValueError(f'views {sorted(missing)}, units {document["units"]!r}')
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f'{path}: is not the poses.json of a run ({error!r})') from None
    return document
