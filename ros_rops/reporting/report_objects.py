# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the report says of each object: quality, coverage, surface, and how its views hang on."""

from collections.abc import Mapping, Sequence
import math
from typing import Any

from ros_rops.reporting.report_files import Document, get, items_of, RunFiles
from ros_rops.reporting.report_graph import graph
from ros_rops.reporting.report_html import (
    Cell, facts, figure, Lengths, note, number_cell, percent, plain_facts, table, text,
    unbroken)
from ros_rops.reporting.report_scene import number_of, turned
from ros_rops.reporting.report_views import view_link

SHOWN = {'surface': 'Surface', 'cloud': 'Points', 'residuals': 'Residual map'}
LENGTHS = {'voxel', 'band', 'spread', 'noise', 'radius', 'cell', 'resolution', 'mesh_resolution'}
"""Facts of surfaces and clouds that are lengths; the areas are `AREAS`."""
AREAS = ('area', 'unseen_area')


def object_article(files: RunFiles, item: Document, scene: Document) -> str:
    """Return all that is said of an object of `poses.json` below its 3D view."""
    object_id = int(item['id'])
    quality = files.quality_of(object_id)
    lengths = Lengths(files.units)
    body = _summary(quality, files)
    cards = [_card('Views', _views(files, item, quality, lengths)),
             _card('View graph', graph(files, item))]
    if quality:
        cards += [_card('Loops', _loops(files, quality, lengths)),
                  _card('Coverage', _coverage(quality, lengths)),
                  _card('Surface', _made(quality, 'surface', lengths, scene)),
                  _card('Cloud', _made(quality, 'cloud', lengths, scene))]
    cards.append(_card('Shown above', _shown(scene)))
    body += f'<div class="cards">{"".join(cards)}</div>'
    return (f'<article class="object" id="object-{object_id}" data-object="{object_id}">'
            f'<h3>Object {object_id}</h3>\n{body}</article>\n')


def _card(title: str, body: str) -> str:
    kind = title.lower().replace(' ', '-')
    return f'<section class="card {kind}"><h4>{text(title)}</h4>\n{body}</section>\n'


def _summary(quality: Document, files: RunFiles) -> str:
    if not quality:
        return note('The quality of its registration is not known: quality.json '
                    + files.missing.get('quality.json', 'says nothing of this object') + '.')
    said = quality.get('summary')
    out = f'<p class="summary">{text(unbroken(str(said)))}</p>\n' if said else ''
    notes = quality.get('notes')
    for one in notes if isinstance(notes, list) else ():
        out += note(str(one))
    worst = quality.get('worst_views')
    if isinstance(worst, list) and worst:
        links = [view_link(files, files.numbers[str(name)]) if str(name) in files.numbers
                 else text(name) for name in worst]
        out += f'<p class="warn">Views that stand out, the worst first: {", ".join(links)}.</p>\n'
    return out


def _views(files: RunFiles, item: Document, quality: Document, lengths: Lengths) -> str:
    measured = {str(view.get('name')): view for view in items_of(quality, 'views')}
    numbers = files.numbers
    own = [(numbers.get(str(view['name']), -1), str(view['name'])) for view in item['views']]
    if not measured:
        return '<p>' + ', '.join(_linked(files, *one) for one in own) + '</p>\n'
    head = ['#', 'view', f'median, {lengths.unit}', f'p90, {lengths.unit}', 'confirmed',
            'contradicted', 'alone', 'least constrained', 'noted']
    rows = [[number_cell(str(number), number), Cell(_linked(files, number, name), name),
             *_view_row(measured.get(name, {}), lengths, left=name in files.left_out)]
            for number, name in own]
    if not any(row[-1] for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    return table(
        head, rows, sortable=True, label=f'Views of object {item["id"]}',
        row_attributes=[f'data-row="{number}"' for number, _ in own])


def _linked(files: RunFiles, number: int, name: str) -> str:
    return view_link(files, number) if number >= 0 else text(name)


def _view_row(quality: Document, lengths: Lengths, *, left: bool) -> list[Cell | str]:
    row: list[Cell | str] = []
    for key in ('median', 'p90'):
        value = get(quality, 'residual', key)
        row.append(number_cell(lengths.bare(value), value))
    for key in ('confirmed', 'contradicted', 'alone'):
        row.append(number_cell(percent(quality.get(key)), quality.get(key)))
    loose = quality.get('least_constrained')
    stiffness = number_of(get(loose, 'stiffness'))
    row.append(Cell(f'<span class="words">{text(unbroken(_loose(loose)))}</span>',
                    math.inf if stiffness is None else stiffness))
    flags = quality.get('flags')
    said = ['left out of the model'] if left else []
    return [*row, '; '.join([*said, *map(str, flags if isinstance(flags, list) else ())])]


def _loose(loose: Any) -> str:
    """Return the motion that holds a view least, in words."""
    if not isinstance(loose, Mapping):
        return ''
    if loose.get('text'):
        return str(loose['text'])
    return f'{loose.get("kind", "")} (stiffness {figure(loose.get("stiffness"))})'


def _loops(files: RunFiles, quality: Document, lengths: Lengths) -> str:
    loops = quality.get('loops')
    if not isinstance(loops, Mapping):
        return note('No loop of views is known that could show an error.')
    items = [('loops', figure(loops.get('count')))]
    for key, name in (('mean', 'mean'), ('max', 'largest')):
        turn, shift = get(loops, 'rotation_deg', key), get(loops, 'translation', key)
        items.append((f'{name} error', f'{figure(turn)}°, {lengths.text(shift)}'))
    worst = loops.get('worst')
    if isinstance(worst, Mapping) and isinstance(worst.get('views'), list):
        names = [files.shown.get(str(one), str(one)) for one in worst['views']]
        items.append(('worst loop', ' → '.join(names) + (
            f': {figure(worst.get("rotation_deg"))}°, {lengths.text(worst.get("translation"))}')))
    return facts(items)


def _coverage(quality: Document, lengths: Lengths) -> str:
    coverage = quality.get('coverage')
    if not isinstance(coverage, Mapping):
        return note('What has not been seen is not known.')
    items = [
        ('not seen', f'{percent(coverage.get("unseen_share"))}, '
         + _area(coverage.get('unseen_area'), lengths)),
        ('area', _area(coverage.get('area'), lengths)),
        ('holes', figure(coverage.get('holes')))]
    turntable = coverage.get('turntable')
    if isinstance(turntable, Mapping):
        items.append(('on the turntable', turned(turntable)))
    return facts(items) + _directions(items_of(coverage, 'directions'))


def _directions(directions: Sequence[Document]) -> str:
    if not directions:
        return ''
    rows: list[list[Cell | str]] = []
    for k, one in enumerate(directions):
        at = one.get('direction')
        shown = ', '.join(figure(v) for v in at) if isinstance(at, list) else '–'
        look = (f'<button type="button" data-look="{k}">look from there</button>'
                if isinstance(at, list) else '')
        rows.append([number_cell(str(k + 1), k), Cell(f'<span class="n">({shown})</span>', shown),
                     number_cell(percent(one.get('gain_share')), one.get('gain_share')),
                     Cell(look)])
    return '<p>Where the sensor should stand next, from the object:</p>\n' + table(
        ['', 'direction', 'shows of the unseen', ''], rows, label='Next best directions')


def _made(quality: Document, part: str, lengths: Lengths, scene: Document) -> str:
    """Return the facts of the surface or the cloud; lengths among them with their unit."""
    document = quality.get(part)
    if not isinstance(document, Mapping) or not document:
        missing = get(scene, 'missing', part)
        return note(f'{missing}.' if missing else 'Nothing more is known of it.')
    items = []
    for name, value in plain_facts(document):
        key = name.replace(' ', '_')
        if key in LENGTHS:
            value = lengths.text(document.get(key))
        if key in AREAS:
            value = _area(document.get(key), lengths)
        if value:
            items.append((name, value))
    return facts(items)


def _area(value: Any, lengths: Lengths) -> str:
    area = number_of(value)
    return '–' if area is None else f'{figure(area * lengths.factor ** 2)} {lengths.unit}²'


def _shown(scene: Document) -> str:
    """Return how much of what is in the files the 3D view shows."""
    items = []
    for name, title in SHOWN.items():
        layer = get(scene, 'layers', name)
        if layer is None:
            items.append((title, f'{get(scene, "missing", name) or "unknown"}'))
        elif 'triangles' in layer:
            items.append((title, _of(layer['triangles'], layer['of_triangles'], 'triangles')))
            if layer['filled']:
                items.append(('of them filled, striped',
                              percent(layer['filled'] / max(layer['triangles'], 1))))
        else:
            items.append((title, _of(layer['count'], layer['of'], 'points')))
    return facts(items)


def _of(shown: int, there: int, what: str) -> str:
    if shown >= there:
        return f'all {figure(there)} {what}'
    return f'{figure(shown)} of {figure(there)} {what} ({percent(shown / there)})'
