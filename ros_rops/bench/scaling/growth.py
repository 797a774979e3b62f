# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How measured quantities grow: table, exponents held against what they must, plot, notes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ros_rops.bench.experiment import Case
from ros_rops.bench.scaling.law import fit_law, Law
from ros_rops.bench.table import table


@dataclass(frozen=True, slots=True)
class Quantity:
    """
    What is fitted against the size.

    Parameters
    ----------
    name : str
        Of the case's value.
    label : str
    must, aim : float or None
        Most that the exponent may be; None where nothing is asked.
    """

    name: str
    label: str
    must: float | None = None
    aim: float | None = None


@dataclass(frozen=True, slots=True)
class Growth:
    """
    Cases of growing size.

    Parameters
    ----------
    size : str
        Name of the case's value that grows.
    axis : str
        What the plot calls it.
    quantities : tuple of Quantity
    """

    size: str
    axis: str
    quantities: tuple[Quantity, ...]

    def law(self, cases: Sequence[Case], quantity: Quantity) -> Law | None:
        """Return the law of one quantity."""
        return fit_law([case[self.size] for case in cases],
                       [case[quantity.name] for case in cases])

    def show(self, cases: Sequence[Case]) -> str:
        """Return a line a case, then a line a fitted exponent, as Markdown."""
        rows = [[
            case[self.size], case['views'] if self.size != 'views' else case['objects'],
            f'{case["points_per_view"]:.0f}', f'{case["seconds"]:.2f}',
            f'{case["seconds_add"]:.2f}', f'{case["seconds_finish"]:.2f}',
            f'{case["cpu_seconds"]:.2f}', f'{case["peak_rss_mib"]:.0f}',
            f'{case["session_mib"]:.0f}', case['attempts'], case['placed'],
            case['wrong_placements'], case['wrong_merges'], case['splits']] for case in cases]
        other = 'views' if self.size != 'views' else 'objects'
        return table(
            [self.size, other, 'points', 's', 'add', 'finish', 'CPU s', 'MiB', 'session MiB',
             'registrations', 'placed', 'wrong', 'merges', 'splits'], rows,
        ) + '\n' + self._exponents(cases)

    def _exponents(self, cases: Sequence[Case]) -> str:
        rows = [
            [quantity.label, law or '-', _number(quantity.must), _number(quantity.aim),
             reached(law, quantity)]
            for quantity in self.quantities
            for law in [self.law(cases, quantity)]]
        return table(
            [f'grows with {self.size} by the power', 'exponent', 'must', 'aim', 'reached'], rows)

    def missed(self, cases: Sequence[Case]) -> list[str]:
        """Return a sentence on every exponent that is above what it must be."""
        laws = [(quantity, self.law(cases, quantity)) for quantity in self.quantities]
        return [
            f'{quantity.label}: exponent {law} is above {quantity.must}'
            for quantity, law in laws if reached(law, quantity) == 'neither']

    def plot(self, cases: Sequence[Case], path: Path) -> None:
        """Draw every quantity against the size, both axes logarithmic, each with its law."""
        from ros_rops.bench.scaling.plot import draw

        draw(self.axis, [case[self.size] for case in cases], [
            (quantity.label, [case[quantity.name] for case in cases], self.law(cases, quantity))
            for quantity in self.quantities], path)


def reached(law: Law | None, quantity: Quantity) -> str | None:
    """Return 'aim', 'must' or 'neither'; None where nothing is asked or known."""
    if law is None or quantity.must is None or quantity.aim is None:
        return None
    if law.exponent <= quantity.aim:
        return 'aim'
    return 'must' if law.exponent <= quantity.must else 'neither'


def misplaced(cases: Sequence[Case], size: str) -> list[str]:
    """Return a sentence on every case in which a view is wrong, missing or apart."""
    return [
        f'{case[size]} {size}: {case["placed"]} of {case["views"]} placed, '
        f'{case["wrong_placements"]} wrong, {case["wrong_merges"]} merged wrongly, '
        f'{case["splits"]} split'
        for case in cases
        if case['placed'] < case['views'] or any(
            case[name] for name in ('wrong_placements', 'wrong_merges', 'splits'))]


def _number(value: float | None) -> str | None:
    return None if value is None else f'{value:g}'
