# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""JSON files that people read too: a row of a matrix is on a line."""

from collections.abc import Mapping
import json
from pathlib import Path
import re
from typing import Any

from ros_rops.recordings.atomic import replace_file


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """
    Write a JSON file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    text = json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False)
    # A row of a matrix on a line; within a string a line never breaks.
    text = re.sub(r'\[\s+([-+.\deE,\s]+?)\s+\]', _row, text)
    replace_file(path, text + '\n')


def _row(found: re.Match[str]) -> str:
    return '[' + ' '.join(found.group(1).split()) + ']'
