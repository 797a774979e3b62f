# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Experiment `scaling_views`: more and more views of one object."""

from collections.abc import Sequence
from typing import Any

from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.scaling.growth import Growth, misplaced, Quantity
from ros_rops.bench.scaling.sessions import measured, session_job
from ros_rops.bench.scaling.shapes import captures_of, distinct_models

VIEWS = (10, 20, 50, 100, 200)
PIXELS = 280
# Pairwise registrations that N views of one object may take.
MOST_REGISTRATIONS = 1.3
AIM_REGISTRATIONS = 2

GROWTH = Growth('views', 'views of one object', (
    Quantity('seconds', 'seconds', 1.2, 1.05), Quantity('cpu_seconds', 'CPU seconds'),
    Quantity('attempts', 'registrations'), Quantity('session_mib', "session's MiB")))


def views_experiment(
    counts: Sequence[int] = VIEWS, pixels: int = PIXELS
) -> Experiment:
    """Return the experiment for some numbers of views, images of `pixels` squared."""

    def run(laboratory: Laboratory) -> list[dict[str, Any]]:
        model, = distinct_models(laboratory.models, 1)
        cases = []
        for count in counts:
            laboratory.tell(f'scaling: {count} views of {model.name}')
            captures = captures_of(model, count, pixels=pixels, seed=laboratory.seed)
            cases.append(measured(session_job(captures, laboratory), laboratory.repeats))
        return cases

    return Experiment(
        'scaling_views', 'Growth with the number of views',
        'Views rendered all around one object, neither noise nor order nor pose known to the '
        'engine; seconds from the first `add` to the end of `finish`, views in memory, warm; '
        'registrations are those of a view or shape against a shape that were attempted.',
        run, GROWTH.show, GROWTH.plot, notes_on)


def notes_on(cases: Sequence[Case]) -> list[str]:
    """Return what falls short, then the registrations beyond one less than the views."""
    most = max((case['attempts'] / case['views'] for case in cases), default=0.0)
    over = [case for case in cases if case['attempts'] > case['views'] + AIM_REGISTRATIONS]
    word = f'registrations: at most {most:.2f} N (must {MOST_REGISTRATIONS} N'
    word += ', not reached)' if most > MOST_REGISTRATIONS else ')'
    word += f', above N + {AIM_REGISTRATIONS} in {len(over)} of {len(cases)} runs'
    return [word, *GROWTH.missed(cases), *misplaced(cases, 'views')]
