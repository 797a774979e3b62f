# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 6: noise."""

from collections.abc import Iterator
from functools import partial

from ros_rops.bench.disturbed import noisy
from ros_rops.bench.experiment import Experiment
from ros_rops.bench.paper.robustness import Disturbance, robustness_cases
from ros_rops.bench.paper.robustness_show import (
    plot_robustness, robustness_notes, show_robustness)
from ros_rops.bench.truth import ReferenceSet

LABELS = {0.0: '0', 0.25: '0.25', 0.5: '0.5', 0.75: '0.75', 1.0: '1.0'}


def _noisy(dataset: ReferenceSet, seed: int) -> Iterator[ReferenceSet]:
    return (noisy(dataset, sigma, seed) for sigma in LABELS)


NOISE = Disturbance(
    unit='noise, dres', labels=LABELS, compared=(0.0, 0.5, 1.0),
    asked={0.5: (0.95, 0.98), 1.0: (0.75, 0.90)}, worsened=_noisy,
    paper=(
        'recall is almost unaffected below 0.5 dres and still acceptable at 1.0; RoPS is best at '
        'all levels, USC second, LSP and THRIFT fall off rapidly.'))

EXPERIMENT = Experiment(
    name='fig6', title='Fig. 6: noise',
    about=(
        'Gaussian noise on x, y and z of every point, its standard deviation in dres. The engine '
        'with its defaults: correct and accepted pairs of those with an overlap of at least 0.1, '
        'in brackets the share of the undisturbed recall that is kept. Truth, dres and overlaps '
        'are those of the set without noise. *Wrong*: accepted but not correct, of these pairs; '
        '*wrong without overlap*: the same of up to 20 pairs of a set that overlap by less, drawn '
        'once for all levels. *mr*: of the mesh that the engine makes, which evens noise out '
        'first. *Unprepared*: views refused, and all their pairs with them. *Features alone*: no '
        'random starts, at most 20 poses refined, the descriptor exchanged; meshes, keypoints and '
        "frames are the engine's in every line, so rivals have the evened surface, too. At most "
        '12 pairs of a bin of overlap, of the last set given, and three levels only, to save '
        'time.'),
    run=partial(robustness_cases, disturbance=NOISE),
    show=partial(show_robustness, disturbance=NOISE),
    plot=partial(plot_robustness, disturbance=NOISE),
    notes=partial(robustness_notes, disturbance=NOISE))
