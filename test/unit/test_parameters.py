# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameter files. Truth: what was written is what is read; ROS's file form."""

from hypothesis import given, strategies
import pytest
from ros_rops.core.config import Config, describe
from ros_rops.core.errors import ParameterError
from ros_rops.pipeline.parameters import (
    dump_config,
    load_config,
    parse_assignments,
    parse_parameters,
    scalar_text,
)
import yaml


def test_defaults_survive_a_round_trip(tmp_path):
    path = tmp_path / 'config.yaml'
    for comments in (False, True):
        path.write_text(dump_config(Config(), comments), encoding='utf-8')
        assert load_config(path) == Config()


def test_changed_values_survive_a_round_trip(tmp_path):
    config = Config.from_flat({'rops.radius_mr': 12.345678901234567, 'lrf.method': 'toldi'})
    path = tmp_path / 'config.yaml'
    path.write_text(dump_config(config), encoding='utf-8')
    assert load_config(path) == config != Config()


@given(strategies.one_of(
    strategies.booleans(), strategies.integers(),
    strategies.floats(allow_nan=False, allow_infinity=False),
    strategies.text(strategies.characters(codec='ascii', categories=['L', 'N']))))
def test_scalars_keep_type_and_bits(value):
    read = yaml.safe_load(scalar_text(value))
    assert type(read) is type(value) and read == value


@pytest.mark.parametrize('word', ['y', 'N', 'yes', 'off', 'null', '1e5', '12', 'nan', ''])
def test_words_that_yaml_takes_for_something_else_are_quoted(word):
    assert scalar_text(word).startswith("'") and yaml.safe_load(scalar_text(word)) == word


def test_form_of_ros2_param_dump():
    text = (
        '/ros_rops:\n  ros__parameters:\n    rops:\n      radius_mr: 12.0\n'
        '    use_sim_time: false\n    qos_overrides:\n      /tf:\n        depth: 3\n'
        '    start_type_description_service: true\n')
    assert parse_parameters(text) == {'rops.radius_mr': 12.0}


def test_node_comes_over_any_node_and_dotted_names_are_read():
    text = (
        '/ros_rops:\n  ros__parameters: {rops.bins: 6}\n'
        '/**:\n  ros__parameters: {rops: {bins: 7, rotations: 4}}\n')
    assert parse_parameters(text) == {'rops.bins': 6, 'rops.rotations': 4}


def test_empty_files_mean_defaults(tmp_path):
    for text in ('', '# nothing\n', '/**:\n  ros__parameters:\n'):
        path = tmp_path / 'empty.yaml'
        path.write_text(text, encoding='utf-8')
        assert load_config(path) == Config()


@pytest.mark.parametrize(('text', 'message'), [
    ('/**: [', 'not YAML'),
    ('- 3', 'expected a node name'),
    ('rops: {bins: 3}', 'ros__parameters'),
    ('/**:\n  ros__parameters: 3\n', 'holds no parameters'),
    ('/a:\n  ros__parameters:\n/b:\n  ros__parameters:\n', 'more than one node: /a, /b'),
    ('/**:\n  ros__parameters: {rops: {bin: 3}}', 'rops.bin: no such parameter'),
    ('/**:\n  ros__parameters: {rops: {bins: 3.5}}', 'rops.bins: expected int, got 3.5'),
    ('/**:\n  ros__parameters: {rops: {bins: true}}', 'rops.bins: expected int, got True'),
    ('/**:\n  ros__parameters: {rops: {bins: [3]}}', r'rops.bins: expected int, got \[3\]'),
    ('/**:\n  ros__parameters: {rops: {radius_mr: .nan}}', 'rops.radius_mr: must be finite'),
    ('/**:\n  ros__parameters: {rops: {radius_mr: -1.0}}', 'rops.radius_mr: -1.0 is below'),
])
def test_faults_name_file_and_parameter(tmp_path, text, message):
    path = tmp_path / 'bad.yaml'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(ParameterError, match=f'bad.yaml: .*{message}'):
        load_config(path)


def test_unreadable_files_are_named(tmp_path):
    with pytest.raises(ParameterError, match='none.yaml: cannot be read'):
        load_config(tmp_path / 'none.yaml')
    binary = tmp_path / 'binary.yaml'
    binary.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ParameterError, match='binary.yaml: is no text'):
        load_config(binary)


def test_assignments_are_typed():
    texts = ['rops.bins=6', 'rops.radius_mr = 0.5', 'lrf.method=toldi']
    assert parse_assignments(texts) == {
        'rops.bins': 6, 'rops.radius_mr': 0.5, 'lrf.method': 'toldi'}


@pytest.mark.parametrize('text', ['rops.bins', '=3', ''])
def test_wrong_assignments_say_the_form(text):
    with pytest.raises(ParameterError, match='expected name=value'):
        parse_assignments([text])


def test_every_parameter_says_something():
    for info in describe():
        assert info.description.endswith('.'), info.name
        assert info.name.endswith('_mr') == (info.unit == 'mr'), info.name
