# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Results on disk and as sections of a document. Truth: what was put in; BENCHMARKS.md itself."""

import argparse
import json
import math

from meta.tree import ROOT
import pytest
from ros_rops.bench.document import section, update_document, with_sections
from ros_rops.bench.experiment import Experiment
from ros_rops.bench.laboratory import run_laboratory
from ros_rops.bench.results import read_result, Result, write_result
from ros_rops.bench.settings import add_common_arguments
from ros_rops.bench.stored import stored_sections
from ros_rops.core.errors import InputError

MACHINE = {'cpu': 'a cpu', 'cores': 2, 'load_1min': 0.1, 'git_commit': 'abcdef0123456789'}


def count_experiment(**changes):
    return Experiment(**{
        'name': 'count', 'title': 'Counting', 'about': 'How many.',
        'run': lambda laboratory: [{'views': len(laboratory.sets), 'ratio': math.nan}],
        'show': lambda cases: f'{cases[0]["views"]} sets\n', **changes})


def test_a_result_comes_back_as_it_was(tmp_path):
    result = Result('count', 'rops bench paper', MACHINE, 1.5, [{'a': 1, 'b': [0.5, None]}])
    assert read_result(write_result(tmp_path / 'new', result)) == result


def test_what_json_does_not_know_is_stored_as_missing(tmp_path):
    path = write_result(
        tmp_path, Result('count', 'c', MACHINE, math.inf, [{'ratio': math.nan}]))
    assert json.loads(path.read_text())['cases'] == [{'ratio': None}]


@pytest.mark.parametrize(
    'content', ['', '[]', '{}', '{"experiment": "count"}', '{"cases": 3', 'null'])
def test_a_file_that_is_no_result_is_named(tmp_path, content):
    path = tmp_path / 'count.json'
    path.write_text(content)
    with pytest.raises(InputError, match=r'count\.json: is not the result'):
        read_result(path)


def test_a_missing_or_unwritable_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r'none\.json: cannot be read'):
        read_result(tmp_path / 'none.json')
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match='cannot be written'):
        write_result(tmp_path / 'file', Result('count', 'c', MACHINE, 1.0, []))


def test_only_what_stands_between_the_marks_is_replaced():
    text = 'by hand\n<!-- result a -->\nold\n<!-- end a -->\nalso <!-- result b --><!-- end b -->.'
    assert with_sections(text, {'a': 'new \\1\n', 'b': 'B\n'}) == (
        'by hand\n<!-- result a -->\nnew \\1\n<!-- end a -->\n'
        'also <!-- result b -->\nB\n<!-- end b -->.')


def test_a_document_without_the_place_is_left_alone(tmp_path):
    path = tmp_path / 'doc.md'
    path.write_text('<!-- result a -->\n<!-- end a -->')
    with pytest.raises(InputError, match="no place for 'b'"):
        update_document(path, {'a': 'A', 'b': 'B'})
    assert path.read_text() == '<!-- result a -->\n<!-- end a -->'


def test_a_section_holds_command_table_notes_and_machine():
    experiment = count_experiment(notes=lambda cases: ['one is missing'])
    text = section(experiment, Result('count', 'rops bench x', MACHINE, 3.2, [{'views': 4}]))
    for part in ('### Counting', '`rops bench x`', 'How many.', '4 sets', '- one is missing',
                 'a cpu, 2 cores', 'abcdef0123,', '3 s'):
        assert part in text


def test_an_experiment_is_shown_stored_and_documented(tmp_path, capsys):
    document = tmp_path / 'doc.md'
    document.write_text('<!-- result count -->\n<!-- end count -->\n')
    parser = argparse.ArgumentParser()
    add_common_arguments(parser, count='*')
    args = parser.parse_args(['--json', str(tmp_path / 'all.json'), '--quiet'])
    vars(args).update(
        mesh=[], only=None, out=tmp_path / 'out', document=document, seed=0, repeats=1)
    drawn = []
    experiment = count_experiment(plot=lambda cases, path: drawn.append(path.name))
    assert run_laboratory('paper', args, [experiment]) == 0
    assert '0 sets' in capsys.readouterr().out
    assert '0 sets' in document.read_text()
    assert drawn == ['count.svg']
    assert read_result(tmp_path / 'out' / 'count.json').command == 'rops bench paper --only count'
    stored = json.loads((tmp_path / 'all.json').read_text())['cases']
    assert stored == [{'experiment': 'count', 'views': 0, 'ratio': None}]


def test_a_folder_without_results_or_with_an_unknown_one_is_named(tmp_path):
    with pytest.raises(InputError, match='holds no results'):
        stored_sections(tmp_path)
    write_result(tmp_path, Result('elsewhere', 'c', MACHINE, 1.0, []))
    with pytest.raises(InputError, match="no experiment 'elsewhere'"):
        stored_sections(tmp_path)


def test_benchmarks_say_what_the_stored_results_say():
    folder = ROOT / 'docs' / 'results'
    if not any(folder.glob('*.json')):
        pytest.skip('docs/results holds no results')
    text = (ROOT / 'BENCHMARKS.md').read_text(encoding='utf-8')
    assert with_sections(text, stored_sections(folder)) == text
