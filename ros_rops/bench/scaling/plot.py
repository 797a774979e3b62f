# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Quantities against a size, as an SVG whose bytes depend on the numbers alone."""

from collections.abc import Sequence
from pathlib import Path

from ros_rops.bench.scaling.law import Law
from ros_rops.core.errors import InputError

COLOURS = ('#1b6ca8', '#c2571a', '#3b7d4f', '#7a4fa3')
MARKS = ('o', 's', '^', 'D')

Series = tuple[str, Sequence[float], Law | None]


def draw(axis: str, sizes: Sequence[float], series: Sequence[Series], path: Path) -> None:
    """
    Draw (label, values, law) each against the sizes, both axes logarithmic.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullLocator, ScalarFormatter

    with matplotlib.rc_context({'svg.hashsalt': 'ros_rops', 'font.size': 9}):
        figure = Figure(figsize=(6.4, 3.8), layout='constrained')
        axes = figure.subplots()
        for (label, values, law), colour, mark in zip(series, COLOURS, MARKS, strict=False):
            points = [(x, y) for x, y in zip(sizes, values, strict=True) if y and y > 0]
            text = label if law is None else f'{label}: {law}'
            axes.plot(
                [x for x, _ in points], [y for _, y in points], mark, color=colour, label=text,
                markersize=5)
            if law is not None:
                ends = [min(sizes), max(sizes)]
                axes.plot(
                    ends, [law.factor * x ** law.exponent for x in ends], color=colour,
                    linewidth=1)
        axes.set_xscale('log')
        axes.set_yscale('log')
        axes.set_xticks(sorted(set(sizes)))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel(axis)
        axes.grid(True, which='major', color='#dddddd', linewidth=0.6)
        axes.spines[['top', 'right']].set_visible(False)
        # Outside: the lines may cross every corner.
        figure.legend(loc='outside upper left', frameon=False, ncols=2, title='with exponents')
        try:
            figure.savefig(path, format='svg', metadata={'Date': None})
        except OSError as error:
            raise InputError(
                f'{path}: cannot be written ({error.strerror or error})') from None
