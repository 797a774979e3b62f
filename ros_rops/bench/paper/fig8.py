# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 8: fewer vertices."""

from collections.abc import Iterator
from functools import partial

from ros_rops.bench.disturbed import decimated
from ros_rops.bench.experiment import Experiment
from ros_rops.bench.paper.robustness import Disturbance, robustness_cases
from ros_rops.bench.paper.robustness_show import (
    plot_robustness, robustness_notes, show_robustness)
from ros_rops.bench.peers.extras import open3d_missing
from ros_rops.bench.truth import ReferenceSet

# One vertex of so many is left.
LABELS = {1.0: '1', 2.0: '1/2', 4.0: '1/4', 8.0: '1/8', 16.0: '1/16', 32.0: '1/32'}


def _decimated(dataset: ReferenceSet, seed: int) -> Iterator[ReferenceSet]:
    return decimated(dataset, [round(part) for part in LABELS])


VERTICES = Disturbance(
    unit='vertices', labels=LABELS, compared=(1.0, 8.0, 16.0),
    asked={8.0: (0.9, 0.97), 16.0: (0.75, 0.9)}, worsened=_decimated,
    paper=(
        'down to 1/16 of the vertices recall is comparable with that of the original meshes, at '
        '1/32 it drops; RoPS is best at all levels, USC falls off sharply below 1/2.'),
    missing=open3d_missing)

EXPERIMENT = Experiment(
    name='fig8', title='Fig. 8: fewer vertices',
    about=(
        "Open3D's quadric decimation of each view's mesh; the vertices left become a view without "
        'a grid. The engine with its defaults: correct and accepted pairs of those with an '
        'overlap of at least 0.1, in brackets the share of the undisturbed recall that is kept. '
        'Truth, overlaps and dres, in which errors are measured (5 at most), are those of the '
        'set as it was. *Wrong*: accepted but not correct, of these pairs; *wrong without '
        'overlap*: the same of up to 20 pairs of a set that overlap by less, drawn once for all '
        'levels. *mr*: of the mesh that the engine makes of the points left. *Unprepared*: views '
        'refused, and all their pairs with them. *Features alone*: no random starts, at most 20 '
        'poses refined, the descriptor exchanged; meshes, keypoints and frames are the '
        "engine's in every line. At most 12 pairs of a bin of overlap, of the last set given, and "
        'three levels only, to save time.'),
    run=partial(robustness_cases, disturbance=VERTICES),
    show=partial(show_robustness, disturbance=VERTICES),
    plot=partial(plot_robustness, disturbance=VERTICES),
    notes=partial(robustness_notes, disturbance=VERTICES))
