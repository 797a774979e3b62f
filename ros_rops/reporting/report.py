# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
`report.html`: a run folder as one page that opens by a double click.

Nothing is loaded from anywhere: pictures, geometry, style and scripts are in the file, and its
content policy forbids the rest. The page is made of the folder's files alone, so it can be made
of any run, also of an older one: what a folder lacks is said in its place.
"""

from base64 import b64encode
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.recordings.atomic import replace_file
from ros_rops.reporting.report_files import items_of, read_run_folder, RunFiles
from ros_rops.reporting.report_graph import hex_colour
from ros_rops.reporting.report_head import head_section
from ros_rops.reporting.report_html import data_script, Lengths, note, text
from ros_rops.reporting.report_objects import object_article
from ros_rops.reporting.report_run import (
    input_section, machine_section, parameters_section, reproduce_section, times_section)
from ros_rops.reporting.report_scene import no_scene, scenes, unit_vector
from ros_rops.reporting.report_stage import stage
from ros_rops.reporting.report_views import every_view, not_placed, views_table

REPORT = 'report.html'
ASSETS = Path(__file__).parent / 'assets'
SCRIPTS = ('unpack.js', 'viewer.js', 'page.js')
MEGA = 1_000_000
MOST_OF_PICTURE = 0.3
"""Of the limit; a larger picture stays beside the report."""
SHRINK = 0.8


def write_report(folder: Path) -> Path:
    """
    Write `report.html` of a run folder; return its path.

    The same folder gives the same bytes.

    Parameters
    ----------
    folder : Path
        What `write_run` wrote, models or not.

    Raises
    ------
    InputError
        If it has no sound `poses.json`, or the report cannot be written.
    """
    files = read_run_folder(folder)
    path = folder / REPORT
    try:
        replace_file(path, _page_within(files, _limit(files)))
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(f'{path}: cannot be made of files that are damaged ({error!r})') from None
    return path


def _limit(files: RunFiles) -> int:
    """Return how many characters the page may have; all of them are ASCII but for names."""
    return (files.config or Config()).model.report_mb * MEGA


def _page_within(files: RunFiles, limit: int) -> str:
    """Return the page: first without geometry to see what that may take, then with it."""
    picture = files.picture if len(files.picture) < MOST_OF_PICTURE * limit else b''
    bare = len(_page(files, picture, [no_scene(files, item) for item in files.poses['objects']])
               .encode())
    budget = max(limit - bare, 0)
    while True:
        page = _page(files, picture, list(scenes(files, budget, limit)))
        excess = len(page.encode()) - limit
        if excess <= 0 or budget < 0.01 * limit:
            return page
        budget = int(SHRINK * max(budget - excess, 0))


def _page(files: RunFiles, picture: bytes, drawn: Sequence[dict[str, Any]]) -> str:
    title = f'{files.folder.resolve().name} – registration report'
    scripts = [(ASSETS / name).read_text(encoding='utf-8') for name in SCRIPTS]
    policy = ("default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src "
              + ' '.join(f"'sha256-{_digest(script)}'" for script in scripts))
    sections = [
        head_section(files), _part('not-placed', _left_title(files), not_placed, files),
        _part('objects', 'Objects', lambda files: _objects(files, drawn), files),
        _part('views', 'All views', views_table, files),
        _part('stories', 'What happened to each view', every_view, files),
        _section('pictures', 'Picture', _picture(files, picture)),
        _part('input', 'Input', input_section, files),
        _part('parameters', 'Parameters', parameters_section, files),
        _part('times', 'Times', times_section, files),
        _part('machine', 'Machine and versions', machine_section, files),
        _part('again', 'How to do it again', reproduce_section, files)]
    data = data_script('page-data', _page_data(files, drawn)) + ''.join(
        data_script(f'geometry-{scene["id"]}', scene) for scene in drawn)
    page = (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{text(policy)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<title>{text(title)}</title>\n<link rel="icon" href="data:,">\n<style>\n'
        f'{(ASSETS / "report.css").read_text(encoding="utf-8")}</style></head>\n<body>\n<main>\n'
        + '\n'.join(sections) + '\n</main>\n' + data
        + ''.join(f'<script>{script}</script>\n' for script in scripts) + '</body></html>\n')
    # A name of a file may have halves of characters, which no text file can hold.
    return page.encode('utf-8', 'replace').decode('utf-8')


def _left_title(files: RunFiles) -> str:
    return 'Not placed, or left out of the model' if files.left_out else 'Not placed'


def _digest(script: str) -> str:
    return b64encode(sha256(script.encode()).digest()).decode('ascii')


def _section(name: str, title: str, body: str) -> str:
    return f'<section id="{name}"><h2>{text(title)}</h2>\n{body}</section>\n'


def _part(name: str, title: str, make: Callable[[RunFiles], str], files: RunFiles) -> str:
    """Return a section; one that the files are too damaged for says so, and no other is lost."""
    try:
        return _section(name, title, make(files))
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        return _section(name, title, note(
            f'A file of the run folder is damaged: this part cannot be made of it ({error!r}).'))


def _objects(files: RunFiles, drawn: Sequence[dict[str, Any]]) -> str:
    objects = files.poses['objects']
    if not objects:
        return note('There is no object: no two views were registered to each other.')
    return stage(files, objects) + ''.join(
        object_article(files, item, scene) for item, scene in zip(objects, drawn, strict=True))


def _page_data(files: RunFiles, drawn: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what the scripts have to know of the run."""
    lengths = Lengths(files.units)
    names = [str(view['name']) for view in files.views]
    return {
        'unit': lengths.unit, 'factor': lengths.factor,
        'resolution': files.poses.get('mesh_resolution'),
        'objects': [{
            'id': scene['id'], 'views': [
                {'number': number, 'name': names[number], 'short': files.shown[names[number]],
                 'left': names[number] in files.left_out, 'colour': hex_colour(k)}
                for k, number in enumerate(scene['views'])],
            'directions': _looks(files, scene['id'])} for scene in drawn]}


def _looks(files: RunFiles, object_id: int) -> list[Any]:
    return [unit_vector(one.get('direction'))
            for one in items_of(files.quality_of(object_id), 'coverage', 'directions')]


def _picture(files: RunFiles, picture: bytes) -> str:
    if not picture:
        why = files.missing.get('picture.png', 'is too large; it lies beside this report')
        return note(f'picture.png {why}.')
    return ('<figure><img id="picture" alt="Every object from three sides, coloured by view" '
            f'src="data:image/png;base64,{b64encode(picture).decode("ascii")}"></figure>\n')
