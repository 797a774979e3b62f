# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A picture of a frame: its depth, why points were dropped, and what was kept."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes
from ros_rops.reporting.picture import PALETTE
from ros_rops.segmentation.result import Label, REASONS

COLOURS: Mapping[Label, tuple[int, int, int]] = {
    Label.HOLE: (20, 20, 24),
    Label.KEPT: (255, 255, 255),
    Label.TOO_NEAR: (148, 103, 189),
    Label.TOO_FAR: (70, 90, 140),
    Label.OUTSIDE_BOX: (150, 150, 90),
    Label.BACKGROUND: (110, 110, 110),
    Label.PLANE: (44, 130, 70),
    Label.BELOW_PLANE: (120, 78, 66),
    Label.BESIDE_PLANE: (90, 60, 110),
    Label.NOT_STANDING: (255, 187, 60),
    Label.EDGE: (214, 39, 40),
    Label.SPECK: (227, 119, 194),
    Label.OTHER_OBJECT: (23, 190, 207),
}


def draw_frame(
    path: Path, document: Mapping[str, Any], depth: NDArray[np.float32], labels: Bytes,
    objects: NDArray[np.int16],
) -> None:
    """
    Write a PNG of three panels.

    Parameters
    ----------
    path : Path
    document : mapping
        As `frame_document` makes it.
    depth : (h, w) float32
        NaN where nothing was measured.
    labels : (h, w) uint8
    objects : (h, w) int16
        Index of the view that a pixel went to, -1 for none.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4.4), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 3)
    _draw_depth(figure, axes[0], depth, document['units'])
    table = np.array([COLOURS[label] for label in Label], np.uint8)
    axes[1].imshow(table[labels], interpolation='nearest')
    axes[1].set_title('what became of the points', fontsize=8)
    _draw_kept(axes[2], depth, objects, document['views'])
    for axis in axes:
        axis.set_axis_off()
    _legend(figure, document['counts'])
    notes = ''.join(f'\n{note}' for note in document['notes'])
    figure.suptitle(document['name'] + notes, fontsize=8)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.86, bottom=0.16, wspace=0.04)
    figure.savefig(path, format='png', metadata={'Software': None})


def _draw_depth(figure: Any, axis: Any, depth: NDArray[np.float32], units: str) -> None:
    known = depth[np.isfinite(depth)]
    low, high = np.quantile(known, [0.01, 0.99]) if known.size else (0.0, 1.0)
    shown = axis.imshow(depth, cmap='viridis_r', vmin=low, vmax=high, interpolation='nearest')
    axis.set_title(f'distance from the sensor ({units})', fontsize=8)
    bar = figure.colorbar(shown, ax=axis, fraction=0.035, pad=0.02)
    bar.ax.tick_params(labelsize=6)


def _draw_kept(
    axis: Any, depth: NDArray[np.float32], objects: NDArray[np.int16], views: Any
) -> None:
    """Draw the objects, each in its colour, shaded by the slope of the depth."""
    image = np.ones((*depth.shape, 3))
    kept = objects >= 0
    if kept.any():
        inside = np.where(kept, depth, np.nan)
        slope = np.gradient(inside, axis=0) if min(depth.shape) > 1 else np.zeros(depth.shape)
        known = slope[np.isfinite(slope)]
        wide = max(float(np.quantile(np.abs(known), 0.9)), 1e-12) if known.size else 1.0
        shade = 0.7 + 0.3 * np.clip(np.nan_to_num(slope / wide), -1, 1)
        image[kept] = PALETTE[objects[kept] % len(PALETTE)] * shade[kept, None]
    axis.imshow(image, interpolation='nearest')
    if kept.any():
        rows, columns = np.flatnonzero(kept.any(axis=1)), np.flatnonzero(kept.any(axis=0))
        axis.set_xlim(columns[0] - 2.5, columns[-1] + 2.5)
        axis.set_ylim(rows[-1] + 2.5, rows[0] - 2.5)
    points = ' + '.join(str(view['points']) for view in views)
    axis.set_title(f'kept: {points or 0} points', fontsize=8)


def _legend(figure: Any, counts: Mapping[str, int]) -> None:
    from matplotlib.patches import Patch

    total = max(1, sum(counts.values()))
    handles = [
        Patch(
            facecolor=(red / 255, green / 255, blue / 255), edgecolor='grey',
            label=f'{REASONS[label]}: {100 * counts[label.name.lower()] / total:.1f}%')
        for label, (red, green, blue) in COLOURS.items() if counts[label.name.lower()]]
    figure.legend(
        handles=handles, fontsize=6.5, loc='lower center', ncols=4, frameon=False)
