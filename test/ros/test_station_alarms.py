# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the log says of the station. Truth: a folder that is taken away."""

import shutil

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import station  # noqa: E402, I100


def test_a_save_that_fails_is_in_the_log(tmp_path):
    with station(tmp_path) as (process, client):
        shutil.rmtree((tmp_path / 'latest').resolve())
        assert client.ask('save')[0]
        assert 'ERROR' in process.says('not saved')
