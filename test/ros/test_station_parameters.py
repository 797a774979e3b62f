# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The registration node's parameters, by ROS's own parameter services.

Truth: the dataclasses of core/config.py and core/node_config.py; the layout of a dump is that of
ros2cli's `param dump`.
"""

from itertools import chain

import pytest
import yaml

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from rcl_interfaces.srv import DescribeParameters, SetParametersAtomically  # noqa: E402, I100
from ros.harness import Client, NODE, ROOT, station  # noqa: E402
from ros.parameter_client import (  # noqa: E402
    get_values, KINDS, message_of, names_of, set_values)
from ros_rops.cli.main import main as rops  # noqa: E402
from ros_rops.core.config import describe  # noqa: E402
from ros_rops.core.node_config import describe_node  # noqa: E402
from ros_rops.pipeline.parameters import configs_of, load_config, parse_parameters  # noqa: E402


def _dump(client: Client) -> str:
    """Return what `ros2 param dump` writes."""
    names = names_of(client)
    tree: dict = {}
    for name, value in zip(names, get_values(client, *names), strict=True):
        branch = tree
        *groups, leaf = name.split('.')
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[leaf] = value
    return yaml.dump({NODE: {'ros__parameters': tree}}, default_flow_style=False)


GIVEN = {'rops.radius_mr': 14.0, 'selection.stride': 7, 'output.models': False,
         'output.report': False}


@pytest.fixture(scope='module')
def running(tmp_path_factory):
    folder = tmp_path_factory.mktemp('parameters')
    with station(folder, {**GIVEN, 'rops.radius_mr': 14}) as (process, client):
        yield process, client


def test_every_parameter_is_declared_with_its_default(running):
    _, client = running
    infos = {info.name: info for info in chain(describe(), describe_node())}
    names = names_of(client)
    assert infos.keys() <= set(names)
    for name, value in zip(infos, get_values(client, *infos), strict=True):
        expected = GIVEN.get(name, infos[name].default)
        if name != 'output.folder':
            assert value == expected and type(value) is type(infos[name].default), name


def test_every_parameter_is_described(running):
    _, client = running
    infos = {info.name: info for info in chain(describe(), describe_node())}
    answer = client.call(DescribeParameters, f'{NODE}/describe_parameters',
                         DescribeParameters.Request(names=list(infos)))
    for found, info in zip(answer.descriptors, infos.values(), strict=True):
        assert found.name == info.name
        assert found.type == KINDS[type(info.default)]
        assert info.description in found.description
        assert not info.unit or f'Unit: {info.unit}.' in found.description
        assert all(choice in found.additional_constraints for choice in info.choices)
        assert found.read_only == (info.name == 'autostart')
        ranges = [*found.integer_range, *found.floating_point_range]
        assert len(ranges) == (info.low is not None or info.high is not None)
        for limits in ranges:
            assert info.low is None or limits.from_value == info.low
            assert info.high is None or limits.to_value == info.high


def test_dump_of_a_running_node_is_a_file_for_rops(running, tmp_path):
    _, client = running
    text = _dump(client)
    path = tmp_path / 'dump.yaml'
    path.write_text(text, encoding='utf-8')
    config, node = configs_of(parse_parameters(text))
    assert config == load_config(path)
    assert (config.rops.radius_mr, config.selection.stride) == (14.0, 7)
    assert node.output.folder
    out = tmp_path / 'out'
    # A recording without a frame that can be read would do as well: the file is what matters.
    assert rops(['register', str(ROOT / 'bags' / 'demo.mcap'), '--config', str(path), '--out',
                 str(out), '--set', 'selection.method=stride']) in (0, 1)
    assert (out / 'poses.json').exists()


def test_live_parameters_change_while_active(running):
    _, client = running
    assert set_values(
        client, selection__method='stride', segmentation__far_m=1.5,
        publish__tf_rate_hz=5.0) == [(True, '')] * 3
    assert get_values(client, 'selection.method', 'segmentation.far_m') == ['stride', 1.5]
    assert set_values(client, model__voxel_mr=2.0, model__formats='ply, glb') == [(True, '')] * 2
    assert client.ask('save')[0]


def test_what_cannot_be_is_refused_and_stays(running):
    _, client = running
    names = ('selection.method', 'segmentation.far_m', 'selection.stride', 'autostart')
    before = get_values(client, *names)
    results = set_values(
        client, selection__method='sometimes', segmentation__far_m=-1.0,
        selection__stride='many', autostart=False)
    assert not any(success for success, _ in results)
    assert 'sometimes' in results[0][1] and 'request' in results[0][1]
    assert 'segmentation.far_m' in results[1][1]
    assert get_values(client, *names) == before
    assert set_values(client, model__formats='ply,step') == [
        (False, "model.formats: 'step' is none of ply, stl, obj, glb")]


def test_fixed_parameters_say_what_to_do(running):
    _, client = running
    for name, value in (('rops.radius_mr', 20.0), ('input.kind', 'depth'), ('threads', 1),
                        ('output.folder', 'x'), ('growth.pairs', 1), ('resume', True)):
        if name in {info.name for info in chain(describe(), describe_node())}:
            [(success, reason)] = set_values(client, **{name.replace('.', '__'): value})
            assert not success and reason.startswith(name)
            assert 'clean it up' in reason and 'configure' in reason


def test_same_value_of_a_fixed_parameter_is_no_change(running):
    """Tools that set whole files (`ros2 param load`) send what is there already."""
    _, client = running
    assert set_values(client, rops__radius_mr=14.0) == [(True, '')]


def test_atomic_requests_hold_all_or_nothing(running):
    _, client = running
    before = get_values(client, 'selection.still_s')
    answer = client.call(
        SetParametersAtomically, f'{NODE}/set_parameters_atomically',
        SetParametersAtomically.Request(parameters=[
            message_of('selection.still_s', 9.0), message_of('rops.radius_mr', 20.0)]))
    assert not answer.result.successful and 'rops.radius_mr' in answer.result.reason
    assert get_values(client, 'selection.still_s') == before
