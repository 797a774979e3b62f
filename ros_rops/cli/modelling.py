# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What follows when the poses of a run are written: models, what they say of it, the report."""

import gc
from pathlib import Path
import sys

from ros_rops.cli.progress import Progress
from ros_rops.core.errors import RopsError
from ros_rops.intake.run_file import RunFile
from ros_rops.reporting.models import make_models, ModelTask


def complete(folder: Path, run_file: RunFile, task: ModelTask) -> None:
    """
    Make the models and the report of a run, as far as they are wanted.

    Nothing that fails here, Ctrl-C included, costs the poses, or raises.
    """
    gc.collect()  # what the session held
    try:
        if run_file.models:
            _models(folder, task)
    except KeyboardInterrupt:
        _warn(f'interrupted; the poses are written, and `rops model {folder}` makes the models')
    except (RopsError, OSError) as error:
        _warn(f'no models: {error}')
    if run_file.report:
        report(folder)


def report(folder: Path) -> None:
    """Write the report of a run; say if it cannot be written."""
    try:
        from ros_rops.reporting.report import write_report

        write_report(folder)
    except KeyboardInterrupt:
        _warn(f'interrupted; `rops report {folder}` writes report.html')
    except Exception as error:  # whatever it is, the run stands
        _warn(f'{folder}: report.html is not written ({error})')


def _models(folder: Path, task: ModelTask) -> None:
    with Progress(len(task.document['objects'])) as progress:
        made = make_models(folder, task, say=progress.say)
    for note in made.notes:
        _warn(note)


def _warn(text: str) -> None:
    print(f'warning: {text}', file=sys.stderr)
