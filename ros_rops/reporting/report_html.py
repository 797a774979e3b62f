# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The few pieces of HTML that the report is made of. What comes from outside is escaped here."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
import json
import math
import re
from typing import Any

STATUSES = ('placed', 'pending', 'ambiguous', 'refused')
MM = {'m': 1000.0, 'mm': 1.0}
LEFT_OUT = 'left out'
"""Word on a view that has a place, but is in no model."""
SHORT = 20
"""Letters that need no column of their own width."""


@dataclass(frozen=True, slots=True)
class Lengths:
    """Lengths of a run as the report writes them: in mm where the run's units are known."""

    units: str

    @property
    def factor(self) -> float:
        """Return what a length of the run is multiplied by."""
        return MM.get(self.units, 1.0)

    @property
    def unit(self) -> str:
        """Return the unit's name as it stands behind a number."""
        return 'mm' if self.units in MM else 'units'

    def text(self, value: Any) -> str:
        """Return a length with its unit."""
        return '–' if _number(value) is None else f'{self.bare(value)} {self.unit}'

    def bare(self, value: Any) -> str:
        """Return a length without its unit."""
        number = _number(value)
        return '–' if number is None else figure(number * self.factor)


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell of a table: its HTML, and what it is sorted by (its text, if None)."""

    html: str
    key: float | str | None = None


def text(value: Any) -> str:
    """Return anything as text of a page: nothing in it is taken for HTML."""
    return escape(str(value))


def figure(value: Any, digits: int = 3) -> str:
    """Return a number with so many significant digits, a count whole, a dash for none."""
    number = _number(value)
    if number is None:
        return '–'
    if isinstance(value, int) or (number.is_integer() and abs(number) < 1e9):
        return f'{int(number):,}'.replace(',', '\u202f').replace('-', '\u2212')
    places = max(digits - 1 - math.floor(math.log10(abs(number))), 0)
    if places > 6:
        return f'{number:.{digits - 1}e}'
    return f'{number:.{places}f}'.replace('-', '\u2212')


def percent(value: Any) -> str:
    """Return a share as a percentage."""
    number = _number(value)
    if number is None:
        return '–'
    return f'{number:.0%}' if number == 0 or 0.0995 <= number else f'{number:.1%}'


def seconds(value: Any) -> str:
    """Return a time."""
    number = _number(value)
    return '–' if number is None else f'{number:.2f} s' if number < 10 else f'{number:.0f} s'


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) else None


def number_cell(shown: str, value: Any) -> Cell:
    """Return a cell that is sorted by a number; without one it comes last."""
    number = _number(value)
    return Cell(f'<span class="n">{text(shown)}</span>', math.inf if number is None else number)


def table(
    head: Sequence[str], rows: Iterable[Sequence[Cell | str]], *, sortable: bool = False,
    row_attributes: Sequence[str] = (), label: str = '',
) -> str:
    """
    Return a table in a box of its own that scrolls where the page is narrow.

    Parameters
    ----------
    head : sequence of str
        Text of the columns' heads.
    rows : iterable of sequences of Cell or str
        A str is text.
    sortable : bool
        Whether the heads sort.
    row_attributes : sequence of str
        HTML attributes of each row.
    label : str
        Accessible name.
    """
    heads = ''.join(
        f'<th scope="col"><button type="button">{text(name)}</button></th>' if sortable and name
        else f'<th scope="col">{text(name)}</th>' for name in head)
    body = []
    for k, row in enumerate(rows):
        attributes = row_attributes[k] if k < len(row_attributes) else ''
        body.append(f'<tr {attributes}>' + ''.join(map(_cell, row)) + '</tr>\n')
    kind = ' class="sortable"' if sortable else ''
    return (f'<div class="box" tabindex="0" role="region" aria-label="{text(label)}">'
            f'<table{kind}><thead><tr>{heads}</tr></thead>\n<tbody>{"".join(body)}</tbody></table>'
            '</div>\n')


def _cell(cell: Cell | str) -> str:
    if isinstance(cell, str):
        kind = ' class="words"' if len(cell) > SHORT else ''
        return f'<td{kind}>{text(unbroken(cell))}</td>'
    if cell.key is None:
        return f'<td>{cell.html}</td>'
    key = '' if cell.key == math.inf else cell.key
    return f'<td data-key="{text(key)}">{cell.html}</td>'


def facts(items: Iterable[tuple[str, str]]) -> str:
    """Return a list of names and values (both text) in columns."""
    rows = ''.join(
        f'<div><dt>{text(name)}</dt><dd{" class=words" if len(value) > SHORT else ""}>'
        f'{text(unbroken(value))}</dd></div>' for name, value in items)
    return f'<dl class="facts">{rows}</dl>\n'


def unbroken(words: str) -> str:
    """Return text that no line ends in a vector, or between a number and its unit."""
    whole = re.sub(r'\([-\u2212\d.,e+ ]+\)', lambda found: found[0].replace(' ', '\xa0'), words)
    return re.sub(r'(?<=\d) (?=(mm|m|mr|s|°|%)\b)', '\xa0', whole)


def chip(status: str) -> str:
    """Return the word on a view, marked by colour and by sign."""
    known = status if status in STATUSES else 'left' if status == LEFT_OUT else 'refused'
    return f'<span class="chip {known}">{text(status)}</span>'


def note(sentence: str) -> str:
    """Return a sentence that says what is missing, in its place."""
    return f'<p class="note">{text(sentence)}</p>\n'


def data_script(name: str, content: Any) -> str:
    """Return a block of data: no text in it can end the block or begin another."""
    data = json.dumps(content, separators=(',', ':'), ensure_ascii=True, allow_nan=False)
    for sign in '<>&':
        data = data.replace(sign, f'\\u{ord(sign):04x}')
    return f'<script type="application/json" id="{text(name)}">{data}</script>\n'


def humanised(name: str) -> str:
    """Return the name of a number as words."""
    return name.replace('_', ' ')


def plain_facts(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the entries of a document that are scalars, as names and values."""
    found = []
    for name, value in document.items():
        if isinstance(value, bool):
            found.append((humanised(name), 'yes' if value else 'no'))
        elif isinstance(value, str):
            found.append((humanised(name), value))
        elif isinstance(value, (int, float)):
            found.append((humanised(name), figure(value)))
    return found
