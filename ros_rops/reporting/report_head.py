# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The head of the report: what came out, at a glance."""

from collections import Counter

from ros_rops.reporting.report_files import get, items_of, RunFiles
from ros_rops.reporting.report_html import (
    figure, Lengths, percent, seconds, STATUSES, text, unbroken)

LINKS = (
    ('not-placed', 'Not placed'), ('objects', 'Objects'), ('views', 'All views'),
    ('stories', 'Each view'), ('pictures', 'Picture'), ('input', 'Input'),
    ('parameters', 'Parameters'), ('times', 'Times'), ('machine', 'Machine'), ('again', 'Again'))


def head_section(files: RunFiles) -> str:
    """Return title, sentences and figures."""
    counts = Counter(str(view['status']) for view in files.views)
    total, objects = len(files.views), len(files.poses['objects'])
    left = [f'{counts[status]} {status}' for status in STATUSES[1:] if counts[status]]
    if files.left_out:
        left.append(f'{len(files.left_out)} placed but left out of the model')
    verdict = (f'{counts["placed"]} of {_count(total, "view")} placed in '
               f'{_count(objects, "object")}' + (f'; {", ".join(left)}' if left else ''))
    said = ''
    if not files.poses.get('complete', True):
        said += ('<p class="warn">A part of the input was not read; the result is of the rest.'
                 '</p>\n')
    for item in items_of(files.quality, 'objects'):
        if item.get('summary') and objects <= 6:
            said += (f'<p>Object {text(item.get("id"))}: {text(unbroken(str(item["summary"])))}'
                     '</p>\n')
    links = ''.join(f'<a href="#{name}">{text(title)}</a>' for name, title in LINKS)
    return (
        f'<header><h1>{text(files.folder.resolve().name)}</h1>\n'
        f'<p class="verdict">{verdict}.</p>\n{said}{_tiles(files, counts)}'
        f'<nav aria-label="Sections">{links}</nav></header>\n')


def _tiles(files: RunFiles, counts: Counter[str]) -> str:
    lengths = Lengths(files.units)
    tiles = [
        ('placed', figure(counts['placed']), f'of {_count(len(files.views), "view")}'),
        ('not placed', figure(len(files.views) - counts['placed']),
         f'{len(files.left_out)} more left out of the model' if files.left_out else ''),
        ('objects', figure(len(files.poses['objects'])), ''),
        ('mesh resolution', lengths.text(files.poses.get('mesh_resolution') or None),
         '1 mr' + (', units not known' if files.units == 'unknown' else ''))]
    medians = sorted(value for item in items_of(files.quality, 'objects')
                     for view in items_of(item, 'views')
                     if isinstance(value := get(view, 'residual', 'median'), (int, float)))
    if medians:
        tiles.append(('residual', lengths.text(medians[len(medians) // 2]),
                      'median view’s median'))
    unseen = [value for item in items_of(files.quality, 'objects')
              if isinstance(value := get(item, 'coverage', 'unseen_share'), (int, float))]
    if unseen:
        tiles.append(('not seen', percent(max(unseen)),
                      'of the surface' if len(unseen) == 1 else 'at most, of a surface'))
    if files.metrics.get('seconds') is not None:
        tiles.append(('time', seconds(files.metrics['seconds']),
                      f'{figure(files.poses.get("attempts"))} registrations tried'))
    return '<div class="tiles">' + ''.join(
        f'<div class="tile"><b>{text(value)}</b><span>{text(name)}</span><small>{text(more)}'
        '</small></div>' for name, value, more in tiles) + '</div>\n'


def _count(count: int, what: str) -> str:
    return f'{figure(count)} {what}' if count == 1 else f'{figure(count)} {what}s'
