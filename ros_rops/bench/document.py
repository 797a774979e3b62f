# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Results as sections of a Markdown document (BENCHMARKS.md).

A section stands between `<!-- result NAME -->` and `<!-- end NAME -->`; what is written by hand
around the sections stays.
"""

from collections.abc import Mapping
from pathlib import Path
import re

from ros_rops.bench.experiment import Experiment
from ros_rops.bench.results import Result
from ros_rops.core.errors import InputError


def section(experiment: Experiment, result: Result) -> str:
    """Return the Markdown of a result: heading, command, table, notes, machine."""
    lines = [f'### {experiment.title}', '', f'`{result.command}`', '', experiment.about, '',
             experiment.show(result.cases)]
    if experiment.plot is not None:
        lines += [f'![{experiment.title}](docs/results/{experiment.name}.svg)', '']
    if experiment.notes is not None:
        notes = experiment.notes(result.cases)
        lines += [*(f'- {note}' for note in notes), *([''] if notes else [])]
    facts = result.machine
    commit = str(facts.get('git_commit') or 'unknown')[:10]
    lines.append(
        f'{facts["cpu"]}, {facts["cores"]} cores, load {facts["load_1min"]} at the start, commit '
        f'{commit}, {result.seconds:.0f} s.')
    return '\n'.join(lines) + '\n'


def with_sections(text: str, sections: Mapping[str, str]) -> str:
    """
    Replace the sections that a document has a place for.

    Raises
    ------
    InputError
        If the document has no place for one of them.
    """
    for name, content in sections.items():
        begin, end = f'<!-- result {name} -->', f'<!-- end {name} -->'
        pattern = re.compile(re.escape(begin) + '.*?' + re.escape(end), re.DOTALL)
        if not pattern.search(text):
            raise InputError(f'the document has no place for {name!r}: {begin} ... {end}')
        filled = f'{begin}\n{content}{end}'
        text = pattern.sub(lambda match, filled=filled: filled, text)
    return text


def update_document(path: Path, sections: Mapping[str, str]) -> None:
    """
    Rewrite the sections of a document in place.

    Raises
    ------
    InputError
        If it cannot be read or written, or has no place for a section.
    """
    try:
        text = path.read_text(encoding='utf-8')
        path.write_text(with_sections(text, sections), encoding='utf-8')
    except OSError as error:
        raise InputError(f'{path}: cannot be rewritten ({error.strerror or error})') from None
