# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the report says of the run: input, parameters, times, machine, how to do it again."""

from collections.abc import Mapping
import shlex
from typing import Any

from ros_rops.core.config import Config, describe
from ros_rops.reporting.report_files import Document, get, RunFiles
from ros_rops.reporting.report_html import (
    Cell, facts, figure, humanised, note, number_cell, plain_facts, seconds, table, text)
from ros_rops.reporting.table import station_lines

TIMES = {'stage_seconds': 'registration', 'model_seconds': 'models'}


def input_section(files: RunFiles) -> str:
    """Return what was read, and what was known of the station."""
    inputs = files.metrics.get('inputs') or files.run.get('inputs') or ()
    items = [('input', str(one)) for one in inputs] if isinstance(inputs, list) else []
    counts = get(files.metrics, 'frames') or get(files.frames, 'counts')
    if isinstance(counts, Mapping):
        items += [(f'frames {name}', value) for name, value in plain_facts(counts)]
        reasons = counts.get('reasons')
        items += [(f'frames left out: {name}', figure(value)) for name, value in (
            reasons.items() if isinstance(reasons, Mapping) else ())]
    lost = files.metrics.get('lost_inputs')
    items += [(f'lost: {name}', str(why)) for name, why in (
        lost.items() if isinstance(lost, Mapping) else ())]
    said = station_lines(_mapping(files.poses.get('station')), files.units)
    body = ''.join(f'<p>{text(line)}</p>\n' for line in said)
    return (facts(items) if items else note('What was read is not known.')) + body


def reproduce_section(files: RunFiles) -> str:
    """Return the commands that make the run again."""
    command = command_of(files)
    if command is None:
        if get(files.run, 'station'):
            return note('A run of the station: its input is in journal.mcap beside this report.')
        return note('How it was run is not known: run.json '
                    + files.missing.get('run.json', 'does not tell') + '.')
    name = shlex.quote(files.folder.resolve().name)
    return (f'<pre class="box" tabindex="0">{text(command)}\n'
            f'rops model {name}    # the models again, with other parameters\n'
            f'rops report {name}   # this report again</pre>\n')


def command_of(files: RunFiles) -> str | None:
    """Return the command that makes the run again; None where it is not known."""
    inputs = files.run.get('inputs')
    if not isinstance(inputs, list) or not inputs or get(files.run, 'station'):
        return None
    name = files.folder.resolve().name
    words = ['rops', 'register', *map(str, inputs), '--out', f'{name}_again']
    if files.config is not None:
        words += ['--config', f'{name}/config.yaml']
    if files.run.get('units') not in (None, 'auto'):
        words += ['--units', str(files.run['units'])]
    topics = dict.fromkeys(
        str(topic) for source in files.run.get('sources') or () if isinstance(source, Mapping)
        for topic in source.get('topics') or ())
    words += [word for topic in topics for word in ('--topic', topic)]
    background = get(files.run, 'background', 'path')
    if background:
        words += ['--background', str(background)]
    return shlex.join(words)


def parameters_section(files: RunFiles) -> str:
    """Return the parameters: those that differ from their default first, the others folded."""
    if files.config is None:
        return note('The parameters are not known: config.yaml '
                    + files.missing.get('config.yaml', 'is missing') + '.')
    values, defaults = files.config.to_flat(), Config().to_flat()
    changed = [name for name in values if values[name] != defaults[name]]
    known = {info.name: info for info in describe()}

    def row(name: str) -> list[Cell | str]:
        return [Cell(f'<code>{text(name)}</code>', name), str(values[name]), str(defaults[name]),
                known[name].unit, known[name].description]

    head = ['parameter', 'value', 'default', 'unit', 'what']
    out = (table(head, map(row, changed), label='Parameters that differ from their default')
           if changed else '<p>All parameters have their defaults.</p>\n')
    rest = [name for name in values if name not in changed]
    return (f'{out}<details><summary>{len(rest)} parameters at their default</summary>\n'
            + table(head, map(row, rest), label='Parameters at their default') + '</details>\n')


def times_section(files: RunFiles) -> str:
    """Return where the time went, as bars, and how much memory was needed."""
    rows = []
    for key, title in TIMES.items():
        stages = {name: value for name, value in _mapping(files.metrics.get(key)).items()
                  if isinstance(value, (int, float)) and name != 'all'}
        rows += [(title, humanised(str(name)), float(value)) for name, value in stages.items()]
    if not rows:
        return note('Times are not known: metrics.json '
                    + files.missing.get('metrics.json', 'does not tell them') + '.')
    longest = max(max(value for _, _, value in rows), 1e-9)
    cells: list[list[Cell | str]] = [
        [title, name, number_cell(seconds(value), value),
         Cell(f'<span class="bar" style="width:{100 * value / longest:.1f}%"></span>')]
        for title, name, value in rows]
    items = [('whole run', seconds(files.metrics.get('seconds'))),
             ('reading', seconds(files.metrics.get('read_seconds'))),
             ('models', seconds(get(files.metrics, 'model_seconds', 'all'))),
             ('most memory', _mebibytes(files.metrics.get('peak_rss_mib'))),
             ('most memory, models', _mebibytes(files.metrics.get('model_peak_rss_mib'))),
             ('threads', 'all cores' if files.metrics.get('threads') == 0
              else figure(files.metrics.get('threads')))]
    shown = [item for item in items if item[1] != '–']
    return facts(shown) + table(['part', 'stage', 'time', ''], cells, label='Times per stage')


def machine_section(files: RunFiles) -> str:
    """Return machine and versions."""
    machine = plain_facts(_mapping(files.metrics.get('machine')))
    if not machine:
        return note('The machine is not known: metrics.json '
                    + files.missing.get('metrics.json', 'does not tell') + '.')
    return facts(machine)


def _mapping(value: Any) -> Document:
    return value if isinstance(value, Mapping) else {}


def _mebibytes(value: Any) -> str:
    return f'{figure(float(value))} MiB' if isinstance(value, (int, float)) else '–'
