# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command line without the engine. Truth: what the verbs promise in their help."""

import argparse
import importlib
import io
import signal
import sys

import pytest
from ros_rops.cli import doctor
from ros_rops.cli.interrupt import Interrupt
from ros_rops.cli.main import main, VERBS
from ros_rops.cli.notes import Notes
from ros_rops.cli.options import add_engine_arguments, config_of, seeds
from ros_rops.cli.progress import Progress
from ros_rops.core.config import Config
from ros_rops.core.errors import KernelMissingError
from ros_rops.intake.reports import without_figures
import ros_rops.kernels


@pytest.mark.parametrize('verb', VERBS)
def test_every_verb_has_help(verb, capsys):
    with pytest.raises(SystemExit) as done:
        main([verb, '--help'])
    assert done.value.code == 0
    assert f'rops {verb}' in capsys.readouterr().out


@pytest.mark.parametrize(('words', 'message'), [
    ([], 'VERB'), (['fly'], 'fly'), (['register', 'x'], '--out'),
    (['register', 'x', '--out', 'y', '--threads', '-1'], '-1 is below 0'),
    (['register', 'x', '--out', 'y', '--threads', 'all'], "'all' is no number"),
    (['register', 'x', '--out', 'y', '--units', 'inch'], 'inch')])
def test_mistakes_in_the_command_are_named(words, message, capsys):
    with pytest.raises(SystemExit) as done:
        main(words)
    assert done.value.code == 2 and message in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'message'), [
    (['evaluate', 'nowhere', 'nowhere'], 'nowhere: cannot be read'),
    (['explain', 'nowhere'], 'poses.json: cannot be read'),
    (['explain', 'nowhere', 'a', 'b', 'c'], 'VIEW: one or two, got 3'),
    (['register', 'x', '--out', 'y', '--set', 'rops.bins=many'], 'rops.bins: expected int'),
    (['register', 'x', '--out', 'y', '--set', 'rops.radius=9'], 'did you mean rops.radius_mr?'),
    (['register', 'x', '--out', 'y', '--config', 'none.yaml'],
     'none.yaml: cannot be read (No such file')])
def test_callers_mistakes_end_with_2_and_one_line(words, message, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.startswith(f'rops {words[0]}: ') and message in error
    assert error.count('\n') == 1


def _config(*words: str):
    parser = argparse.ArgumentParser()
    add_engine_arguments(parser)
    return config_of(parser.parse_args(words))


def test_options_come_over_the_file_and_the_file_over_the_defaults(tmp_path):
    path = tmp_path / 'config.yaml'
    path.write_text('/**:\n  ros__parameters: {rops: {bins: 6, rotations: 4}}\n', encoding='utf-8')
    config = _config('--config', str(path), '--set', 'rops.bins=7')
    assert (config.rops.bins, config.rops.rotations) == (7, 4)
    assert config.rops.radius_mr == Config().rops.radius_mr


def test_seed_goes_to_every_seed_of_the_engine():
    changed = dict(_config('--seed', '5').to_flat().items() - Config().to_flat().items())
    assert 'pairwise.seed' in changed and set(changed.values()) == {5}
    assert set(changed) == set(seeds())


def test_notes_that_say_the_same_are_said_once():
    notes = Notes()
    notes.add('a.ply', ['a.ply: units inferred: m (0.15 across)'])
    notes.add('set/b.ply', ['b.ply: units inferred: m (0.17 across)', 'sensor unknown'])
    assert notes.lines() == [
        '2 views: units inferred: m (0.15 across) [figures of a.ply]',
        'set/b.ply: sensor unknown']


def test_digits_in_names_are_no_figures():
    assert without_figures('/tf2: tf2_msgs/msg/PointCloud2 of 12 x 3.5e-2 m, -4 mr') == (
        '/tf2: tf2_msgs/msg/PointCloud2 of # x # m, # mr')


def test_notes_without_figures_name_the_first_view_and_count_the_others():
    notes = Notes()
    for name in 'abc':
        notes.add(name, ['sensor unknown'])
    assert notes.lines() == ['a and 2 more: sensor unknown']


def test_the_first_interrupt_asks_and_the_second_stops():
    before = signal.getsignal(signal.SIGINT)
    with Interrupt() as interrupt:
        assert not interrupt.asked
        signal.raise_signal(signal.SIGINT)
        assert interrupt.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


class _Terminal(io.StringIO):

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(('stream', 'lines'), [
    (io.StringIO(), ['1/2 a', '2/2 b', '3/3 c']),
    (_Terminal(), [])])
def test_progress_is_lines_or_one_line_rewritten(stream, lines, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', stream)
    with Progress(2) as progress:
        for text in 'abc':
            progress.step(text)
    if lines:
        assert stream.getvalue().splitlines() == lines
    else:
        shown = stream.getvalue().split('\r')
        assert shown[1].endswith('[############............] 1/2 a')
        assert shown[3].endswith('[########################] 3/3 c\n')


def test_doctor_finds_this_installation_sound(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['doctor']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(doctor.CHECKS)
    assert {line.split()[0] for line in lines} <= {'OK', 'WARN'}


def test_doctor_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, 'NEEDED', ('numpy', 'no-such-package'))
    assert doctor.packages() == ('FAIL', 'missing packages: pip install no-such-package')
    monkeypatch.setenv('ROPS_DATA', str(tmp_path))
    assert doctor.data().level == 'WARN'
    monkeypatch.setattr(doctor.importlib.util, 'find_spec', lambda name: None)
    for check in (doctor.open3d, doctor.ros):
        assert check().level == 'WARN'


def test_missing_kernels_say_how_to_build_them(monkeypatch):
    monkeypatch.setitem(sys.modules, 'ros_rops.kernels._kernels', None)
    monkeypatch.delattr(ros_rops.kernels, '_kernels')
    monkeypatch.delitem(sys.modules, 'ros_rops.kernels')
    with pytest.raises(KernelMissingError, match=r'pip install \.'):
        importlib.import_module('ros_rops.kernels')
    assert doctor.kernels().level == 'FAIL'
