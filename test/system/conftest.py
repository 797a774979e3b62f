# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A small stream and its result, for all tests of whole runs."""

import json
from pathlib import Path
import time
from types import SimpleNamespace

import pytest
from reference.runs import result, start, wait_for, words
from reference.streams import frames, record


@pytest.fixture(scope='session')
def recording(tmp_path_factory) -> Path:
    """Return a recording of four scenes, three frames each."""
    folder = tmp_path_factory.mktemp('stream')
    return record(folder / 'stream.mcap', frames(4, names=('bracket',)))


@pytest.fixture(scope='session')
def whole(recording, tmp_path_factory) -> SimpleNamespace:
    """Return the result of an uninterrupted run, and its seconds since its journal began."""
    out = tmp_path_factory.mktemp('whole') / 'run'
    process = start(*words(recording, out, '--threads', '2'))
    wait_for(out / 'journal.mcap', process)
    started = time.perf_counter()
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    found = result(out)
    assert [len(item['views']) for item in json.loads(found['poses.json'])['objects']] == [4]
    return SimpleNamespace(result=found, seconds=time.perf_counter() - started, out=out)
