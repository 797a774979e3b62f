# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The run folder.

| file | what |
|---|---|
| `poses.json` | the result: objects, poses, the word on every view |
| `object_<id>.ply` | the assembled cloud, each place once; without models every measured point |
| `object_<id>_surface.ply` | its surface; also as .stl, .obj, .glb (`model.formats`) |
| `object_<id>_residuals.ply` | how far the points of each view lie from what the others saw |
| `quality.json` | how far the registration may be trusted, per object and view |
| `report.html` | all of it, to look at |
| `config.yaml` | all parameters, as a ROS parameter file that `--config` takes again |
| `metrics.json` | times per stage, attempts, versions, machine |
| `trace.json` | every registration attempted: what was left after each stage |
| `frames.json` | what became of every frame or file of the input |
| `picture.png` | the objects from three sides, and what was not placed |

Clouds, surfaces, residuals and quality.json are made of the rest (`models`), which is written
first; without models (`--no-model`, `output.models: false`) the plain clouds are written with it.
Beside these lie `run.json` and `journal.mcap`, from which `rops resume` goes on (`intake`).
Beside the folder, `latest` points to the last one written.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
import shutil
from typing import Any

from ros_rops.core.errors import InputError
from ros_rops.core.types import Status
from ros_rops.pipeline.parameters import dump_config
from ros_rops.recordings.writers import write_object
from ros_rops.reporting.clouds import assemble, ObjectCloud
from ros_rops.reporting.json_file import write_json
from ros_rops.reporting.picture import draw_objects
from ros_rops.reporting.poses import plain, poses_document, trace_document
from ros_rops.reporting.run import Run

LATEST = 'latest'
POSES = 'poses.json'
NEW_POSES = 'poses.new'
"""Not the name that others wait for, wherever they look."""
FRESH = '.fresh'
"""Below the run folder: a result that is not whole yet."""


def prepare_folder(folder: Path) -> None:
    """
    Make the run folder, and take out what an earlier run left in it.

    Called before the work begins, so that a run whose result cannot be written does not start.

    Raises
    ------
    InputError
        If it cannot be made or written to.
    """
    with _writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / POSES).exists():
            _clear_objects(folder, keep=())
            _clear_models(folder)
        probe = folder / POSES
        probe.write_text('', encoding='utf-8')
        probe.unlink()


def write_run(
    folder: Path, run: Run, *, picture: bool = True, clouds: bool = True
) -> dict[str, Any]:
    """
    Write all but the models and return the content of `poses.json`.

    What an earlier call wrote stays until all of this is on disk.

    Parameters
    ----------
    folder : Path
    run : Run
    picture : bool
        Whether to draw it.
    clouds : bool
        Whether to write the plain clouds: for a run of which no models are made.

    Raises
    ------
    InputError
        If a file cannot be written; the text names it.
    """
    document = poses_document(run)
    fresh = folder / FRESH
    with _writing(folder):
        shutil.rmtree(fresh, ignore_errors=True)  # of a process that was killed
        fresh.mkdir()
        try:
            _write_files(fresh, run, document, picture=picture, clouds=clouds)
            _move_files(fresh, folder)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
        point_latest(folder)
    return document


def _write_files(
    folder: Path, run: Run, document: dict[str, Any], *, picture: bool, clouds: bool
) -> None:
    (folder / 'config.yaml').write_text(dump_config(run.config), encoding='utf-8')
    write_json(folder / 'metrics.json', metrics_document(run))
    write_json(folder / 'trace.json', trace_document(run))
    plain_clouds = _plain_clouds(run) if picture or clouds else {}
    if clouds:
        _write_clouds(folder, plain_clouds)
    if picture:
        draw_objects(folder / 'picture.png', plain_clouds, document['views'])
    if run.frames:
        write_json(folder / 'frames.json', plain(run.frames))
    write_json(folder / NEW_POSES, document)


def _move_files(fresh: Path, folder: Path) -> None:
    """Put a result in the place of the one before; without `poses.json` none is whole."""
    (folder / POSES).unlink(missing_ok=True)
    names = {path.name for path in fresh.iterdir()} - {NEW_POSES}
    _clear_objects(folder, keep=names)
    _clear_models(folder)
    for name in names:
        (fresh / name).replace(folder / name)
    (fresh / NEW_POSES).replace(folder / POSES)


def metrics_document(run: Run) -> dict[str, Any]:
    """Return what `metrics.json` says; times in seconds."""
    counts = Counter(view['status'] for view in poses_document(run)['views'])
    return {
        'views': {status.value: counts[status.value] for status in Status},
        'objects': len(run.session.objects),
        'attempts': run.session.attempts,
        'stage_seconds': plain(run.session.stage_seconds),
        **plain(run.facts),
    }


def point_latest(folder: Path) -> None:
    """Let `latest` beside `folder` point to it, unless something else has that name."""
    place = folder.resolve()
    link = place.parent / LATEST
    if link.is_symlink() or not link.exists():
        # In one step: another run beside this one may do the same now.
        fresh = place.parent / f'.{LATEST}-{place.name}'
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(place.name)
        fresh.replace(link)


def _plain_clouds(run: Run) -> dict[int, ObjectCloud]:
    return {
        shape.id: assemble(shape, run.session.views, run.config, run.order)
        for shape in run.session.objects}


def _write_clouds(folder: Path, clouds: Mapping[int, ObjectCloud]) -> None:
    for number, cloud in clouds.items():
        write_object(
            folder / f'object_{number}.ply', cloud.points, normals=cloud.normals,
            colors=cloud.colors, view_ids=cloud.view_ids)


def _clear_objects(folder: Path, keep: Collection[str]) -> None:
    """Take out the objects of an earlier result, but for those named in `keep`."""
    for path in folder.glob('object_*.ply'):
        if path.name not in keep:
            path.unlink()


def _clear_models(folder: Path) -> None:
    """Take out what was made of earlier poses."""
    for path in (*folder.glob('object_*_surface.*'), *folder.glob('object_*.png'),
                 folder / 'quality.json', folder / 'report.html'):
        path.unlink(missing_ok=True)


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        place = error.filename or folder
        raise InputError(f'{place}: cannot be written ({error.strerror or error})') from error
