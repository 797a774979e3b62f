# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Experiment `scaling_objects`: the same number of views, of more and more objects."""

from collections.abc import Sequence
from typing import Any

from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.scaling.growth import Growth, misplaced, Quantity
from ros_rops.bench.scaling.sessions import measured, session_job
from ros_rops.bench.scaling.shapes import captures_of, distinct_models
from ros_rops.bench.scaling.views import PIXELS

OBJECTS = (1, 2, 5, 10, 20)
TOTAL = 80

GROWTH = Growth('objects', 'objects, the same number of views in total', (
    Quantity('seconds', 'seconds', 0.5, 0.2), Quantity('cpu_seconds', 'CPU seconds'),
    Quantity('attempts', 'registrations'), Quantity('session_mib', "session's MiB")))


def objects_experiment(
    counts: Sequence[int] = OBJECTS, total: int = TOTAL, pixels: int = PIXELS
) -> Experiment:
    """Return the experiment for some numbers of objects, `total` views of them together."""

    def run(laboratory: Laboratory) -> list[dict[str, Any]]:
        models = distinct_models(laboratory.models, max(counts))
        cases = []
        for count in counts:
            laboratory.tell(f'scaling: {total} views of {count} objects')
            captures = [
                capture
                for number, model in enumerate(models[:count])
                for capture in captures_of(
                    model, share(total, count, number), pixels=pixels, seed=laboratory.seed)]
            cases.append(measured(session_job(captures, laboratory), laboratory.repeats))
        return cases

    return Experiment(
        'scaling_objects', 'Growth with the number of objects',
        'The same number of views in total, mixed, of more and more objects of one size, none '
        'symmetric: the meshes given, then shapes made by formulas. Neighbouring views of an '
        'object, as far apart as 16 around it at most. Measured as above.',
        run, GROWTH.show, GROWTH.plot, notes_on)


def share(total: int, count: int, number: int) -> int:
    """Return how many of `total` views the object `number` of `count` gets."""
    return total // count + (number < total % count)


def notes_on(cases: Sequence[Case]) -> list[str]:
    """Return what falls short."""
    return [*GROWTH.missed(cases), *misplaced(cases, 'objects')]
