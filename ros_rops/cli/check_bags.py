# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Check the recordings of bags/: hashes, and that their commands make them again.

bags/bags.yaml names for each file the command and the hashes (SHA-256). Where another version of
a library compresses or rounds differently, messages are compared, then the frames: nearly all
points must be the same. Exit code 1 if a recording is not what its command makes.
"""

import argparse
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
import hashlib
from io import StringIO
from pathlib import Path
import shlex
from tempfile import TemporaryDirectory

import numpy as np

from ros_rops.cli.demo import find_bags
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.frames import read_frames
from ros_rops.recordings.messages import Cut
from ros_rops.recordings.poses import read_poses
from ros_rops.recordings.simulate import poses_path
from ros_rops.recordings.storage import open_storage

LIST = 'bags.yaml'
SAME_M = 1e-6
"""Points nearer than this are the same."""
SHARE = 0.999
"""Share of the pixels that must be the same where rounding differs."""
MAKE_DEMO = ['python', '-m', 'ros_rops.recordings.make_demo']


@dataclass(frozen=True, slots=True)
class Bag:
    """A recording: its file, the words of its command, the hashes of its files."""

    file: str
    words: tuple[str, ...]
    sha256: dict[str, str]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, nargs='?', metavar='FOLDER',
                        help='holds bags.yaml (default: that of the package)')
    parser.add_argument('--hashes-only', action='store_true', help='do not make them again')


def run(args: argparse.Namespace) -> int:
    """Check every recording, a line each."""
    folder = args.folder or find_bags()
    faults = 0
    for bag in read_list(folder / LIST):
        said = _wrong_hash(folder, bag)
        if not said and not args.hashes_only:
            said, made = remade(folder, bag)
        else:
            made = 'hashes as listed'
        faults += bool(said)
        print(f'{bag.file}: {"WRONG: " + said if said else made}')
    return 1 if faults else 0


def read_list(path: Path) -> list[Bag]:
    """
    Read `bags.yaml`.

    Raises
    ------
    InputError
        If it cannot be read or is not of that form.
    """
    import yaml

    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        return [
            Bag(str(one['file']), tuple(shlex.split(one['command'])),
                {str(k): str(v) for k, v in one['sha256'].items()})
            for one in content['bags']]
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except yaml.YAMLError as error:
        words = ' '.join(str(error).split())
        raise InputError(f'{path}: is no YAML ({words})') from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f'{path}: is no list of recordings ({error!r})') from None


def _wrong_hash(folder: Path, bag: Bag) -> str:
    for name, expected in bag.sha256.items():
        try:
            found = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        except OSError as error:
            return f'{name} cannot be read ({error.strerror or error})'
        if found != expected:
            return f'the hash of {name} is not the one listed'
    return ''


def remade(folder: Path, bag: Bag) -> tuple[str, str]:
    """
    Make a recording again in a scratch folder and compare; (what is wrong or '', how it agrees).

    Raises
    ------
    InputError
        If its command is none of ours.
    """
    with TemporaryDirectory() as scratch:
        _make(bag, Path(scratch))
        old, new = folder / bag.file, Path(scratch) / bag.file
        if not new.is_file():
            return f'its command does not make {bag.file}', ''
        wrong = _poses_differ(poses_path(old), poses_path(new))
        if wrong or old.read_bytes() == new.read_bytes():
            return wrong, 'made again, the same bytes'
        if _messages(old) == _messages(new):
            return '', 'made again, the same messages'
        share = _agreement(old, new)
        if share >= SHARE:
            return '', f'made again, {100 * share:.4f}% of its pixels the same'
        return f'made again, only {100 * share:.2f}% of its pixels are the same', ''


def _make(bag: Bag, scratch: Path) -> None:
    from ros_rops.cli.main import main
    from ros_rops.recordings.make_demo import write_demo

    words = list(bag.words)
    if words[:3] == MAKE_DEMO:
        write_demo(scratch)
    elif words[:2] == ['rops', 'simulate'] and '--out' in words:
        words[words.index('--out') + 1] = str(scratch / bag.file)
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            if main(words[1:]):
                raise InputError(f'{bag.file}: its command fails')
    else:
        raise InputError(f'{bag.file}: its command is no rops simulate')


def _poses_differ(old: Path, new: Path) -> str:
    before, after = read_poses(old), read_poses(new)
    if before.objects != after.objects or before.T_world_view.keys() != after.T_world_view.keys():
        return f'{old.name} tells of other views'
    worst = max(float(np.abs(T - after.T_world_view[name]).max())
                for name, T in before.T_world_view.items())
    return f'poses of {old.name} differ by {worst:.2g}' if worst > SAME_M else ''


def _messages(path: Path) -> list[tuple[str, str, int, bytes]]:
    with open_storage(path) as storage:
        topics = frozenset(channel.topic for channel in storage.channels())
        found = [
            (m.channel.topic, m.channel.kind, m.log_time_ns, bytes(m.data))
            for m in storage.messages(topics) if not isinstance(m, Cut)]
    return sorted(found)


def _agreement(old: Path, new: Path) -> float:
    """Smallest share of the pixels of a frame that are the same in both."""
    pairs = list(read_frames(old)), list(read_frames(new))
    if len(pairs[0]) != len(pairs[1]):
        return 0.0
    return min((_same(a, b) for a, b in zip(*pairs, strict=True)), default=0.0)


def _same(a: object, b: object) -> float:
    if not (isinstance(a, Frame) and isinstance(b, Frame)):
        return 0.0
    if a.name != b.name or a.points.shape != b.points.shape:
        return 0.0
    same = np.isclose(a.points, b.points, rtol=0, atol=SAME_M, equal_nan=True)
    return float(same.all(axis=-1).mean())
