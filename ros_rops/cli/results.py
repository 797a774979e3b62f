# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The result of a run, for the commands that start from one."""

from pathlib import Path
import sys
from typing import Any

from ros_rops.core.errors import InputError
from ros_rops.reporting.poses_file import read_document


def read_result(folder: Path) -> dict[str, Any]:
    """
    Return the content of a run's poses.json.

    Raises
    ------
    InputError
        If the folder is no run, or its run has no result yet.
    """
    if not (folder / 'poses.json').exists():
        raise InputError(
            f'{folder}: the run has no result yet; `rops resume {folder}` goes on with it'
            if (folder / 'run.json').exists() else f'{folder}: is no run folder')
    document = read_document(folder / 'poses.json')
    if not document.get('complete', True):
        print(f'warning: {folder}: a part of the input was not read', file=sys.stderr)
    return document
