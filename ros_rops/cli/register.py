# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Register range views of one or several objects, in any order, into one model per object.

INPUT is a folder of views (PLY, PCD, XYZ, NPZ), a view file, or an MCAP recording with point
clouds. The result goes to the folder that --out names: poses.json, a PLY an object, config.yaml,
metrics.json, trace.json (for `rops explain`), picture.png; `latest` beside it points to it.
Exit code 0 if at least one view was placed, 1 if none, 2 for a mistake in the command.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
import sys
import time
from typing import Any

from ros_rops.cli.interrupt import Interrupt
from ros_rops.cli.notes import Notes
from ros_rops.cli.options import add_engine_arguments, config_of
from ros_rops.cli.progress import Progress
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ViewError
from ros_rops.core.types import RangeView
from ros_rops.recordings.reader import BadView, NotedView
from ros_rops.recordings.sources import find_views, ViewSource
from ros_rops.reporting.run import Refusal, Run
from ros_rops.reporting.table import result_table


@dataclass(slots=True)
class _Intake:
    """What came in so far."""

    order: list[str] = field(default_factory=list)
    refusals: dict[str, Refusal] = field(default_factory=dict)
    notes: Notes = field(default_factory=Notes)
    read_seconds: float = 0.0

    def name(self, given: str) -> str:
        """Return `given`, made unique: two recordings may hold the same topic and time."""
        name, count = given, 1
        while name in self.order:
            count += 1
            name = f'{given}#{count}'
        self.order.append(name)
        return name


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('inputs', nargs='+', metavar='INPUT', help='folder, view or recording')
    parser.add_argument(
        '--out', type=Path, required=True, metavar='DIR', help='where the run is written')
    parser.add_argument('--no-picture', action='store_true', help='do not draw picture.png')
    add_engine_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Register, write the run folder, print the table."""
    document = register(
        args.inputs, args.out, config_of(args), threads=args.threads, units=args.units,
        picture=not args.no_picture)
    print(result_table(document), end='')
    print(f'written to {args.out}')
    return 0 if any(view['status'] == 'placed' for view in document['views']) else 1


def register(
    inputs: Sequence[str | Path], out: Path, config: Config, *, threads: int = 0,
    units: str = 'auto', picture: bool = True,
) -> dict[str, Any]:
    """
    Run a session over `inputs`, write the run folder, return the content of its poses.json.

    Raises
    ------
    InputError
        If an input does not exist or is of no known kind, or the folder cannot be written.
        An input that turns out unreadable is refused instead, and the run goes on.
    """
    # Heavy: what a mistake in the command need not wait for.
    from ros_rops.pipeline.session import Session
    from ros_rops.reporting.run_folder import prepare_folder, write_run

    started = time.perf_counter()
    sources = find_views(inputs)
    prepare_folder(out)
    session = Session(config, threads=threads, units=None if units == 'auto' else units)
    intake = _Intake()
    with Progress(sum(map(_count, sources))) as progress:
        _add_all(session, sources, intake, progress, units)
        progress.say('refining all views of each object together')
        session.finish()
    for line in intake.notes.lines():
        print(line, file=sys.stderr)
    facts = _facts(inputs, intake, threads, time.perf_counter() - started)
    result = Run(session, config, tuple(intake.order), intake.refusals, facts)
    return write_run(out, result, picture=picture)


def _count(source: ViewSource) -> int:
    try:
        return source.count()
    except InputError:
        return 1


def _add_all(
    session: Any, sources: Sequence[ViewSource], intake: _Intake, progress: Progress, units: str,
) -> None:
    with Interrupt() as interrupt:
        for outcome in _outcomes(sources, intake, units):
            progress.step(_take(session, outcome, intake))
            if interrupt.asked:
                progress.say(
                    'interrupted; finishing with the views so far (again to stop at once)')
                break


def _take(session: Any, outcome: NotedView | BadView, intake: _Intake) -> str:
    if isinstance(outcome, BadView):
        return _refuse(intake, intake.name(outcome.name), outcome.reason)
    name = intake.name(outcome.view.name)
    intake.notes.add(outcome.view.name, outcome.notes)
    return _add(session, replace(outcome.view, name=name), intake)


def _outcomes(
    sources: Sequence[ViewSource], intake: _Intake, units: str
) -> Iterator[NotedView | BadView]:
    for source in sources:
        outcomes = iter(source.views(units=units))
        while True:
            started = time.perf_counter()
            outcome = next(outcomes, None)
            intake.read_seconds += time.perf_counter() - started
            if outcome is None:
                break
            yield _located(outcome, source.path)


def _located(outcome: NotedView | BadView, path: Path) -> NotedView | BadView:
    """Take the file's place out of a reason: the result must not depend on where it lies."""
    if isinstance(outcome, BadView):
        return replace(outcome, reason=outcome.reason.removeprefix(f'{path}: '))
    return outcome


def _refuse(intake: _Intake, name: str, reason: str) -> str:
    intake.refusals[name] = Refusal(name, reason)
    return f'{name}: refused: {reason}'


def _add(session: Any, view: RangeView, intake: _Intake) -> str:
    """Give a view to the session and say what came of it."""
    try:
        report = session.add(view)
    except ViewError as error:
        return _refuse(intake, view.name, str(error))
    if report.object_id is not None:
        return f'{view.name}: {report.status.value} in object {report.object_id}'
    return f'{view.name}: {report.status.value}: {report.reason}'


def _facts(
    inputs: Sequence[str | Path], intake: _Intake, threads: int, seconds: float
) -> dict[str, Any]:
    from ros_rops.bench.machine import machine_facts, peak_rss_mib

    return {
        'inputs': [str(item) for item in inputs],
        'threads': threads,
        'seconds': seconds,
        'read_seconds': intake.read_seconds,
        'peak_rss_mib': peak_rss_mib(),
        'machine': machine_facts(),
    }
