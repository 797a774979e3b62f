# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What follows when the poses of a run are written: models, what they say of it, the report."""

from collections.abc import Collection
import gc
from pathlib import Path
import sys
from typing import Any

from ros_rops.cli.progress import Progress
from ros_rops.core.errors import RopsError
from ros_rops.intake.reread import views_of_run
from ros_rops.intake.run_file import RunFile
from ros_rops.reporting.models import make_models, modelled_objects, ModelTask, QUALITY
from ros_rops.reporting.poses_file import read_document


def complete(folder: Path, run_file: RunFile, task: ModelTask) -> None:
    """
    Make the models and the report of a run, as far as they are wanted.

    Nothing that fails here, Ctrl-C included, costs the poses, or raises.
    """
    gc.collect()  # what the session held
    if run_file.models:
        _guarded(folder, task)
    if run_file.report:
        report(folder)


def catch_up(folder: Path, run_file: RunFile, threads: int) -> dict[str, Any] | None:
    """
    Make what a finished run lacks since it was killed meanwhile; the rest stays as it is.

    Returns
    -------
    dict or None
        The content of poses.json; None if nothing is missing.

    Raises
    ------
    InputError
        If poses.json cannot be read.
    """
    document = read_document(folder / 'poses.json')
    there = modelled_objects(folder)
    missing = [shape for shape in document['objects'] if shape['id'] not in there]
    models = run_file.models and bool(missing or not (folder / QUALITY).exists())
    if not models and (not run_file.report or (folder / 'report.html').exists()):
        return None
    print(f'{folder}: the poses are there; what is missing is made', file=sys.stderr)
    if models:
        names = {view['name'] for shape in missing for view in shape['views']}
        try:
            views = views_of_run(
                folder, names, document['units'] or 'unknown', threads=threads)
            _guarded(folder, ModelTask(document, views, run_file.config, threads),
                     [shape['id'] for shape in missing])
        except RopsError as error:  # the inputs may be gone
            _warn(f'no models: {error}')
    if run_file.report:
        report(folder)
    return document


def report(folder: Path) -> None:
    """Write the report of a run; say if it cannot be written."""
    try:
        from ros_rops.reporting.report import write_report

        write_report(folder)
    except KeyboardInterrupt:
        _warn(f'interrupted; `rops report {folder}` writes report.html')
    except Exception as error:  # whatever it is, the run stands
        _warn(f'{folder}: report.html is not written ({error})')


def _guarded(folder: Path, task: ModelTask, only: Collection[int] = ()) -> None:
    try:
        with Progress(len(only or task.document['objects'])) as progress:
            made = make_models(folder, task, only=only, say=progress.say)
    except KeyboardInterrupt:
        _warn(f'interrupted; the poses are written, and `rops model {folder}` makes the models')
    except (RopsError, OSError) as error:
        _warn(f'no models: {error}')
    else:
        for note in made.notes:
            _warn(note)


def _warn(text: str) -> None:
    print(f'warning: {text}', file=sys.stderr)
