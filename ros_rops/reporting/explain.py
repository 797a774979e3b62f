# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Where correspondences were lost: the trace of a run in words."""

from collections.abc import Iterable, Mapping, Sequence
import json
from pathlib import Path
from typing import Any

from ros_rops.core.errors import InputError, ParameterError
from ros_rops.reporting.frame_text import draw_record, frame_of, frame_text, FRAMES, record_of
from ros_rops.reporting.frames import frame_names
from ros_rops.reporting.table import columns, number

Attempt = Mapping[str, Any]

# What each stage leaves for the next, in their order; other numbers are measures.
STAGES = (
    'keypoints_source', 'keypoints_target', 'matches', 'hypotheses', 'ccv_groups', 'refined',
    'distinct')


def explain(folder: Path, names: Sequence[str] = (), picture: Path | None = None) -> str:
    """
    Return the explanation of a run, of a view or frame, or of a pair of views.

    Parameters
    ----------
    folder : Path
        A run folder that `write_run` wrote.
    names : sequence of str
        None, one or two views, by their names or an ending of these that fits one view only; one
        may be a frame that gave no view.
    picture : Path or None
        PNG to draw the frame of the one view into.

    Raises
    ------
    InputError
        If the folder's `poses.json`, `trace.json` or a frame's files cannot be read.
    ParameterError
        If a name fits no view of the run, or several, or a picture is asked for of anything but
        one frame.
    """
    poses, trace = _read(folder / 'poses.json'), _read(folder / 'trace.json')
    try:
        views = {view['name']: view for view in poses['views']}
        attempts = trace['attempts']
        if len(names) == 1:
            return _one_text(folder, names[0], views, attempts, picture)
        if picture is not None:
            raise ParameterError('--picture: draws the frame of one VIEW, got '
                                 f'{len(names) or "none"}')
        if not names:
            return _run_text(views, attempts)
        found = [_find(name, views) for name in names]
        return _pair_text([views[name] for name in found], _of_pair(attempts, found))
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f'{folder}: is not a run folder of this program ({error!r})') from None


def _one_text(
    folder: Path, name: str, views: Mapping[str, Any], attempts: Sequence[Attempt],
    picture: Path | None,
) -> str:
    """Return what became of the frame of a view, where it was written, and of the view."""
    left_out = _left_out(folder, name)
    if left_out and name not in views:
        if picture is not None:
            raise ParameterError(f'--picture: nothing was cut from {name!r}: {left_out}')
        return f'{name}\n  {left_out}\n'
    frames = folder / FRAMES
    alone = [one for one in frame_names(frames) if one not in map(frame_of, views)]
    found = _find(name, [*views, *alone])
    record = record_of(folder, found)
    if picture is not None:
        if record is None:
            raise ParameterError(f'--picture: {found!r} was not cut from a frame, or the run '
                                 f'folder has no {FRAMES}/')
        draw_record(picture, record)
    text = '' if record is None else frame_text(record.document)
    if found not in views:
        return text
    return text + ('\n' if text else '') + _view_text(views[found], attempts_of(attempts, found))


def _left_out(folder: Path, name: str) -> str:
    """Return why a frame was never segmented; empty if it was, or the run tells of no frames."""
    path = folder / 'frames.json'
    for frame in _read(path)['frames'] if path.exists() else ():
        if frame['name'] == name and frame['word'] in ('skipped', 'bad'):
            return f'{frame["word"]}: {frame["reason"]}'
    return ''


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except ValueError as error:
        raise InputError(f'{path}: is no JSON ({error})') from None


def _find(name: str, views: Iterable[str]) -> str:
    known = list(views)
    fitting = [name] if name in known else [one for one in known if one.endswith(name)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise ParameterError(f'VIEW: {name!r} fits {len(fitting)} views: {", ".join(fitting)}')
    raise ParameterError(f'VIEW: the run has no {name!r}; its views: {", ".join(known)}')


def attempts_of(attempts: Sequence[Attempt], name: str) -> list[Attempt]:
    """Return the attempts in which a view took part."""
    return [one for one in attempts if name in one['source_views'] + one['target_views']]


def _of_pair(attempts: Sequence[Attempt], names: Sequence[str]) -> list[Attempt]:
    a, b = names
    return [
        one for one in attempts
        if (a in one['source_views'] and b in one['target_views'])
        or (b in one['source_views'] and a in one['target_views'])]


def _run_text(views: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    rows = [['view', 'status', 'tried', 'lost']]
    for name, view in views.items():
        own = attempts_of(attempts, name)
        rows.append([name, view['status'], str(len(own)), _view_verdict(view, own)])
    return columns(rows)


def _view_verdict(view: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    if view['status'] == 'placed':
        return ''
    if not attempts:
        return f'no registration was tried: {view["reason"]}'
    best = max(attempts, key=depth)
    return f'furthest with {_other(best, view["name"])}: {lost(best)}'


def _other(attempt: Attempt, name: str) -> str:
    return str(attempt['target' if name in attempt['source_views'] else 'source'])


def depth(attempt: Attempt) -> tuple[bool, int, float]:
    """Order attempts by how far they came: accepted, stages survived, score."""
    survived = 0
    for _, value in _counts(attempt):
        if not value:
            break
        survived += 1
    score = attempt['numbers'].get('score')
    return attempt['status'] == 'placed', survived, -1e9 if score is None else score


def _counts(attempt: Attempt) -> list[tuple[str, int]]:
    """Return what was left after each stage that the attempt reached."""
    numbers = attempt['numbers']
    return [(name, int(numbers[name])) for name in STAGES if numbers.get(name) is not None]


def lost(attempt: Attempt) -> str:
    """Return where the correspondences of an attempt were lost, in a sentence."""
    if attempt['status'] == 'placed':
        return 'accepted'
    before = ''
    for name, value in _counts(attempt):
        if value == 0:
            return f'no {name} left{before}: {attempt["reason"]}'
        before = f' of {value} {name}'
    return f'refused by the verdict: {attempt["reason"]}'


def _view_text(view: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    head = f'{view["name"]}: {view["status"]}'
    if view['object'] is not None:
        head += f' in object {view["object"]}'
    if view['reason']:
        head += f': {view["reason"]}'
    return head + '\n\n' + _attempts_text(attempts)


def _pair_text(views: Sequence[Mapping[str, Any]], attempts: Sequence[Attempt]) -> str:
    heads = [_view_text(view, ()).split('\n', 1)[0] for view in views]
    return '\n'.join(heads) + '\n\n' + _attempts_text(attempts)


def _attempts_text(attempts: Sequence[Attempt]) -> str:
    if not attempts:
        return 'no registration was tried\n'
    return '\n'.join(_attempt_text(attempt) for attempt in attempts)


def _side(attempt: Attempt, side: str) -> str:
    """Return the name of a side, and how many views were with it by then."""
    others = len(attempt[f'{side}_views']) - 1
    return str(attempt[side]) + (f' (with {others} more)' if others else '')


def _attempt_text(attempt: Attempt) -> str:
    """Return one attempt: where it was lost, then a line a number and a line a time."""
    rows = [
        [f'  {name}', number(value)] for name, value in attempt['numbers'].items()
    ] + [[f'  {name}', f'{number(value)} s'] for name, value in attempt['seconds'].items()]
    head = f'{_side(attempt, "source")} against {_side(attempt, "target")}: {lost(attempt)}\n'
    return head + (columns(rows) if rows else '')
