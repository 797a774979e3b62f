# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the log says of the station. Truth: the counts given; a folder that is taken away."""

import shutil

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import station  # noqa: E402, I100
from ros_rops.live.words import StationState  # noqa: E402
from ros_rops.nodes.alarms import Alarms  # noqa: E402


class Log:
    """Keeps what is said."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def error(self, text: str) -> None:
        self.said.append(f'error: {text}')

    warning = error


def test_each_thing_is_said_once():
    log = Log()
    alarms = Alarms(log)
    alarms.tell(StationState())
    for _ in range(2):
        alarms.tell(StationState(errors=3, last_error='no', dropped=2, lost={'/a': 1, '/b': 4}))
    assert [text.partition(':')[2].split()[0] for text in log.said] == ['no', '2', '5']
    assert 'and 2 more' in log.said[0]


def test_a_save_that_fails_is_in_the_log(tmp_path):
    with station(tmp_path) as (process, client):
        shutil.rmtree((tmp_path / 'latest').resolve())
        assert client.ask('save')[0]
        assert 'ERROR' in process.says('not saved')
