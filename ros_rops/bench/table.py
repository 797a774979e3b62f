# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Plain text tables of benchmark results."""

from collections.abc import Sequence


def show(value: object, digits: int = 3) -> str:
    """Return a table cell: numbers rounded to `digits`, '-' for what was not measured."""
    if value is None:
        return '-'
    if isinstance(value, float):
        return f'{value:.{digits}f}'
    return str(value)


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return rows under heads, columns aligned, as Markdown that reads well as plain text."""
    cells = [list(heads)] + [[show(value) for value in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(heads))]
    lines = [
        '| ' + ' | '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        + ' |' for row in cells
    ]
    lines.insert(1, '|' + '|'.join('-' * (width + 2) for width in widths) + '|')
    return '\n'.join(lines) + '\n'
