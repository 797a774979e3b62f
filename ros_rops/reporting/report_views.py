# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the report says of each view: its word, why, its numbers, what was tried."""

from collections.abc import Mapping, Sequence
from typing import Any

from ros_rops.reporting.explain import attempts_of, depth, lost
from ros_rops.reporting.report_files import Document, get, items_of, RunFiles
from ros_rops.reporting.report_html import (
    Cell, chip, facts, figure, humanised, LEFT_OUT, Lengths, note, number_cell, percent, STATUSES,
    table, text, unbroken)
from ros_rops.reporting.report_scene import number_of

MOST_ATTEMPTS = 8
"""That the report lists of a view; `rops explain` has the others."""
MOST_FRAMES = 40
"""That gave no view and are listed; `frames.json` has the others."""
NO_NUMBERS = {'name', 'status', 'object', 'reason', 'centroid'}


def not_placed(files: RunFiles) -> str:
    """Return what comes first: the views that are in no model, and why: those misplaced first."""
    order = {status: k for k, status in enumerate(reversed(STATUSES))}
    left = [
        (number, view) for number, view in enumerate(files.views) if view['status'] != 'placed']
    left.sort(key=lambda item: (order.get(item[1]['status'], -1), item[0]))
    dropped = [
        frame for frame in items_of(files.frames, 'frames')
        if frame.get('word') in ('bad', 'empty') and frame.get('name') not in files.numbers]
    out = ''
    words = [(files.numbers[name], LEFT_OUT, why) for name, why in files.left_out.items()]
    words += [(number, str(view['status']), str(view.get('reason') or ''))
              for number, view in left]
    if words:
        rows: list[list[Cell | str]] = [
            [number_cell(str(number), number), Cell(view_link(files, number)),
             Cell(chip(word)), why] for number, word, why in words]
        out += table(['#', 'view', 'status', 'why'], rows, label='Views not placed or left out')
    elif files.views:
        out += '<p class="good">Every view has found its place.</p>\n'
    else:
        out += note('The input gave no views.')
    if dropped:
        rows = [[str(frame.get('name', '')), str(frame.get('word')),
                 str(frame.get('reason') or '')] for frame in dropped[:MOST_FRAMES]]
        out += (f'<h3>Frames that gave no view ({len(dropped)})</h3>\n'
                + table(['frame', 'word', 'why'], rows, label='Frames that gave no view'))
    return out


def view_link(files: RunFiles, number: int) -> str:
    """Return a link to what happened to a view: its name, whole where the pointer rests."""
    name = str(files.views[number]['name'])
    title = f' title="{text(name)}"' if files.shown[name] != name else ''
    return (f'<a href="#view-{number}" data-view="{number}"{title}>'
            f'{text(files.shown[name])}</a>')


def views_table(files: RunFiles) -> str:
    """Return the table of all views; it sorts by any column."""
    if not files.views:
        return ''
    lengths = Lengths(files.units)
    measured = measured_views(files)
    unit = lengths.unit
    head = ['#', 'view', 'status', 'object', 'overlap', f'fit residual, {unit}']
    if measured:
        head += ['points', f'residual median, {unit}', f'p90, {unit}', 'confirmed',
                 'contradicted', 'alone']
    rows = [_row(files, number, lengths, measured.get(str(view['name']), {}), bool(measured))
            for number, view in enumerate(files.views)]
    missing = '' if measured else note(
        'Residuals against the other views, and what these confirm, are not known: quality.json '
        + files.missing.get('quality.json', 'says nothing of the views') + '.')
    return missing + table(
        [*head, 'why'], rows, sortable=True, label='All views',
        row_attributes=[f'data-row="{k}"' for k in range(len(rows))])


def measured_views(files: RunFiles) -> Mapping[str, Document]:
    """Return what `quality.json` says of the views, by name."""
    return {str(view.get('name')): view for item in items_of(files.quality, 'objects')
            for view in items_of(item, 'views')}


def _row(
    files: RunFiles, number: int, lengths: Lengths, quality: Document, wide: bool
) -> list[Cell | str]:
    view = files.views[number]
    word = word_of(files, view)
    fit = view.get('fine_residual_mr', view.get('residual_mr'))
    fit = _in_units(fit, files)
    row: list[Cell | str] = [
        number_cell(str(number), number), Cell(view_link(files, number), str(view['name'])),
        Cell(chip(word), word),
        number_cell(figure(view.get('object')), view.get('object')),
        number_cell(percent(view.get('overlap')), view.get('overlap')),
        number_cell(lengths.bare(fit), fit)]
    if wide:
        residual = quality.get('residual')
        row.append(number_cell(figure(quality.get('points')), quality.get('points')))
        for key in ('median', 'p90'):
            value = get(residual, key)
            row.append(number_cell(lengths.bare(value), value))
        for key in ('confirmed', 'contradicted', 'alone'):
            row.append(number_cell(percent(quality.get(key)), quality.get(key)))
    flags = quality.get('flags')
    said = [str(view.get('reason') or ''), *(flags if isinstance(flags, list) else [])]
    return [*row, '; '.join(filter(None, map(str, said)))]


def word_of(files: RunFiles, view: Document) -> str:
    """Return the word on a view: its status, or that it is left out of the model."""
    return LEFT_OUT if view['name'] in files.left_out else str(view['status'])


def every_view(files: RunFiles) -> str:
    """Return what happened to each view, those not placed open."""
    measured = measured_views(files)
    attempts = [item for item in items_of(files.trace, 'attempts') if _sound(item)]
    notes = {
        str(name): [str(one) for one in frame.get('notes') or ()]
        for frame in items_of(files.frames, 'frames') for name in frame.get('views') or ()}
    out = ''
    if 'trace.json' in files.missing:
        out += note(f'What was tried is not known: trace.json {files.missing["trace.json"]}.')
    for number, view in enumerate(files.views):
        name = str(view['name'])
        out += _story(
            files, number, view, measured.get(name, {}), attempts_of(attempts, name),
            notes.get(name, []))
    return out


def _sound(attempt: Document) -> bool:
    return all(isinstance(attempt.get(key), kind) for key, kind in (
        ('source_views', list), ('target_views', list), ('numbers', Mapping))) and all(
        isinstance(attempt.get(key), str) for key in ('source', 'target', 'status', 'reason'))


def _story(
    files: RunFiles, number: int, view: Document, quality: Document,
    attempts: Sequence[Document], notes: Sequence[str],
) -> str:
    word = word_of(files, view)
    is_open = ' open' if word != 'placed' else ''
    where = '' if view.get('object') is None else f' in object {text(view["object"])}'
    body = ''.join(f'<p>{text(one)}</p>\n' for one in notes)
    body += _quality(quality, Lengths(files.units))
    numbers = [_verdict(key, value, files) for key, value in view.items()
               if key not in NO_NUMBERS]
    if numbers:
        body += '<h4>Numbers of the verdict</h4>\n' + facts(numbers)
    body += _attempts(files, view, attempts)
    return (
        f'<details class="view" id="view-{number}" data-view="{number}"{is_open}><summary>'
        f'<span class="number">{number}</span> <b>{text(view["name"])}</b> {chip(word)}'
        f'{where}<span class="why">{text(view.get("reason") or "")}</span></summary>\n'
        f'<div class="story">{body}</div></details>\n')


def _quality(quality: Document, lengths: Lengths) -> str:
    if not quality:
        return ''
    residual = quality.get('residual')
    items = [(f'residual {key}', lengths.text(get(residual, key)))
             for key in ('mean', 'median', 'p90', 'rms')]
    items += [(key, percent(quality.get(key))) for key in ('confirmed', 'contradicted', 'alone')]
    flags = quality.get('flags')
    said = ''.join(f'<p class="warn">{text(flag)}</p>\n'
                   for flag in (flags if isinstance(flags, list) else ()))
    loose = get(quality, 'least_constrained', 'text')
    if loose:
        said += f'<p>Least constrained: {text(unbroken(str(loose)))}</p>\n'
    return '<h4>Against the other views of the object</h4>\n' + said + facts(items)


def _verdict(key: str, value: Any, files: RunFiles) -> tuple[str, str]:
    """Return the name of a number and its text; lengths in mesh resolutions in mm too."""
    if not key.endswith('_mr'):
        return humanised(key), figure(value)
    length = _in_units(value, files)
    shown = f'{figure(value)} mr'
    return humanised(key.removesuffix('_mr')), (
        shown if length is None else f'{shown}, {Lengths(files.units).text(length)}')


def _in_units(value: Any, files: RunFiles) -> float | None:
    """Return a length given in mesh resolutions in the run's units; None if not known."""
    length, resolution = number_of(value), number_of(files.poses.get('mesh_resolution'))
    return None if length is None or not resolution else length * resolution


def _attempts(files: RunFiles, view: Document, attempts: Sequence[Document]) -> str:
    if not attempts:
        return ''
    best = sorted(attempts, key=depth, reverse=True)
    rows: list[list[Cell | str]] = []
    lengths = Lengths(files.units)
    for one in best[:MOST_ATTEMPTS]:
        own = 'source' if view['name'] in one['source_views'] else 'target'
        other = 'target' if own == 'source' else 'source'
        more = len(one[f'{other}_views']) - 1
        against = files.shown.get(one[other], one[other])
        against += f' (with {more} more)' if more else ''
        numbers = one['numbers']
        residual = _in_units(numbers.get('residual_mr'), files)
        rows.append([Cell(f'<span title="{text(one[other])}">{text(against)}</span>'),
                     Cell(chip(one['status'])), lost(one),
                     number_cell(figure(numbers.get('score')), numbers.get('score')),
                     number_cell(percent(numbers.get('overlap')), numbers.get('overlap')),
                     number_cell(lengths.bare(residual), residual)])
    rest = len(attempts) - len(rows)
    return (
        f'<h4>{len(attempts)} registration{"" if len(attempts) == 1 else "s"} tried'
        f'{f", the {len(rows)} that came furthest" if rest else ""}</h4>\n' + table(
            ['against', 'status', 'outcome', 'score', 'overlap', f'residual, {lengths.unit}'],
            rows, label=f'Registrations tried with {view["name"]}'))
