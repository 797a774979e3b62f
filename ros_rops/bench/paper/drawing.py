# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Figures as SVG, the same bytes for the same numbers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros_rops.core.errors import InputError

PANEL = (4.0, 2.8)
STYLE = {
    'svg.hashsalt': 'ros_rops', 'svg.fonttype': 'none', 'font.size': 9.0,
    'axes.spines.top': False, 'axes.spines.right': False}


@contextmanager
def drawing(columns: int = 1, rows: int = 1) -> Iterator[tuple[Any, Any]]:
    """Give a figure and its axes (rows, columns), in the style of the laboratory."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure((PANEL[0] * columns, PANEL[1] * rows), layout='constrained')
        FigureCanvasSVG(figure)
        yield figure, figure.subplots(rows, columns, squeeze=False)


def saved(figure: Any, path: Path) -> None:
    """
    Write a figure, within `drawing`.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, format='svg', metadata={'Date': None, 'Creator': None})
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
