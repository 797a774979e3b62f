# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The result as a table of text."""

from collections.abc import Mapping, Sequence
from typing import Any

# Numbers of a verdict that are worth a column, where the views have them.
COLUMNS = ('overlap', 'residual_mr', 'score')


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Return `rows` with their cells aligned to columns; the last column is not padded."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    widths[-1] = 0
    return ''.join(
        '  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        + '\n' for row in rows)


def number(value: object) -> str:
    """Return a number with three significant digits, a count whole, '-' for none."""
    if value is None or isinstance(value, str):
        return '-'
    if isinstance(value, float):
        return f'{value:.0f}' if value.is_integer() and abs(value) < 1e9 else f'{value:.3g}'
    return str(value)


def result_table(document: Mapping[str, Any]) -> str:
    """Return the table of a `poses.json`: a line a view, then a line an object and the sum."""
    views = document['views']
    extra = [key for key in COLUMNS if any(view.get(key) is not None for view in views)]
    rows = [['view', 'status', 'object', *extra, 'reason']]
    for view in views:
        rows.append([
            view['name'], view['status'], number(view['object']),
            *(number(view.get(key)) for key in extra), view['reason']])
    return columns(rows) + '\n' + summary(document)


def summary(document: Mapping[str, Any]) -> str:
    """Return the sentences below the table."""
    views, objects = document['views'], document['objects']
    lines = [f'object {item["id"]}: {_count(len(item["views"]), "view")}' for item in objects]
    if objects:
        lines.append(
            f'lengths in {document["units"]}; mesh resolution (mr) '
            f'{number(document["mesh_resolution"])} {document["units"]}')
    lines += station_lines(document.get('station', {}), document['units'])
    placed = sum(view['status'] == 'placed' for view in views)
    lines.append(
        f'{placed} of {_count(len(views), "view")} placed in {_count(len(objects), "object")}; '
        f'{_count(document["attempts"], "registration")} attempted')
    return '\n'.join(lines) + '\n'


def station_lines(said: Mapping[str, Any], units: str) -> list[str]:
    """Say what was known of the station, and what came of it."""
    lines = []
    known = [name for name in ('plane', 'axis', 'order') if said.get(name)]
    if said.get('step_deg'):
        known.append(f'a step of {number(said["step_deg"])} deg')
    if 'fixed_frame' in said:
        known.append(
            f'sensor poses in {said["fixed_frame"]} of {_count(said["sensor_poses"], "view")}')
    if known:
        lines.append(f'known of the station: {", ".join(known)}')
    if said.get('planes_seen') == 0:
        lines.append('no supporting plane was seen: it was not used')
    if 'not_believed' in said:
        lines.append(f'not believed: {said["not_believed"]}')
    if 'axis_found' in said:
        lines.append(_axis(said['axis_found'], units))
    lines += [
        f'object {name}: refined without it, for {why}'
        for name, why in said.get('not_used_to_refine', {}).items()]
    return lines


def _axis(found: Mapping[str, Any] | None, units: str) -> str:
    if found is None:
        return 'no common axis was found: it was not used'
    x, y, z = (f'{value:.4f}' for value in found['direction'])
    return (
        f'axis found along ({x}, {y}, {z}) in the frame of the sensor; '
        f'{found["share_of_motions"]:.0%} of the motions agree, within '
        f'{number(found["tilt_deg"])} deg and {number(found["distance"])} {units}')


def _count(count: int, what: str) -> str:
    return f'{count} {what}' if count == 1 else f'{count} {what}s'
