# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Parameters that the registration node is started with, by words and by files.

Truth: the values given; what the dataclasses of core/config.py allow.
"""

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import NodeProcess, ROOT, ros_arguments, station  # noqa: E402, I100
from ros.parameter_client import get_values, set_values  # noqa: E402
from ros_rops.core.config import Config  # noqa: E402
from ros_rops.core.node_config import NodeConfig  # noqa: E402
from ros_rops.pipeline.parameters import configs_of, parse_parameters  # noqa: E402

CLEANUP, DEACTIVATE, CONFIGURE = 2, 4, 1


def test_unconfigured_everything_may_change(tmp_path):
    with station(tmp_path) as (_, client):
        assert client.change(DEACTIVATE)
        assert not set_values(client, rops__radius_mr=20.0)[0][0]
        assert client.change(CLEANUP)
        other = tmp_path / 'other'
        results = set_values(client, rops__radius_mr=20.0, output__folder=str(other))
        assert results == [(True, '')] * 2
        assert client.change(CONFIGURE)
        assert str(other) in client.ask('save')[1]
        assert not set_values(client, rops__radius_mr=21.0)[0][0]


def test_file_for_any_node_with_a_wrong_name(tmp_path):
    path = tmp_path / 'parameters.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    rops: {radius_mr: 13, radius_mrr: 2.0}\n'
        '    selection:\n      method: still\n    use_sim_time: true\n', encoding='utf-8')
    with station(tmp_path, words=['--params-file', str(path)]) as (process, client):
        assert get_values(client, 'rops.radius_mr', 'selection.method', 'use_sim_time') == [
            13.0, 'still', True]
        assert 'rops.radius_mrr: no such parameter; did you mean rops.radius_mr?' in process.output


@pytest.mark.parametrize(('name', 'value'), [
    ('selection.method', 'y'), ('selection.method', 'sometimes'), ('rops.radius_mr', -1.0),
    ('input.depth', 0), ('threads', 'many')])
def test_start_with_what_cannot_be(tmp_path, name, value):
    arguments = ros_arguments({'output.folder': tmp_path, name: value})
    with NodeProcess('registration_node', arguments, expected=(2,)) as process:
        assert process.wait() == 2
        assert name in process.output


def test_start_with_words_that_are_no_arguments_of_ros():
    with NodeProcess('registration_node', ['--ros-args', '-p', 'nonsense'], expected=(2,)) as node:
        assert node.wait() == 2
        assert 'nonsense' in node.output


def test_presets_are_files_for_the_node_and_the_command():
    for path in sorted((ROOT / 'config').glob('*.yaml')):
        configs = configs_of(parse_parameters(path.read_text(encoding='utf-8')))
        assert isinstance(configs[0], Config) and isinstance(configs[1], NodeConfig), path
