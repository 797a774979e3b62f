# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Find the verb and run it.

A verb is a module of this folder with `add_arguments(parser)` and `run(args) -> exit code`; only
the one asked for is imported. Exit codes: 0 done, 1 done but nothing came of it, 2 the caller's
mistake, 130 interrupted.
"""

import argparse
from collections.abc import Sequence
import importlib
import os
import sys

from ros_rops import __version__
from ros_rops.core.errors import RopsError

VERBS = {
    'register': 'register range views into one model per object',
    'replay': 'register what a recording shows, frame by frame as it was recorded',
    'resume': 'go on with a run that was killed or interrupted',
    'model': 'make the models of a run again, with other parameters',
    'report': 'write report.html of a run again',
    'view': 'look at an object of a run',
    'evaluate': 'judge a run against reference poses',
    'explain': 'tell where the correspondences of a run were lost, stage by stage',
    'export': 'write the result of a run as a recording for other tools',
    'convert': 'turn scan folders into recordings and back, without loss',
    'simulate': 'capture meshes by a simulated depth camera, with exact poses',
    'check-bags': 'check the recordings of bags/: hashes, and that commands make them again',
    'bench': 'measure recall, errors and times on data sets',
    'demo': 'register the recording that ships with the package, and judge it',
    'doctor': 'check this machine and installation',
}


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line `words` (that of the process when None); return the exit code."""
    words = sys.argv[1:] if words is None else list(words)
    args = _parser(words[0] if words else '').parse_args(words)
    try:
        return int(args.run(args))
    except RopsError as error:
        print(f'rops {args.verb}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f'rops {args.verb}: interrupted', file=sys.stderr)
        return 130
    except BrokenPipeError:
        # Whoever read the output has gone; keep Python from complaining when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parser(asked: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rops', description='Register unordered range views into one model per object.')
    parser.add_argument('--version', action='version', version=f'ros_rops {__version__}')
    verbs = parser.add_subparsers(dest='verb', required=True, metavar='VERB')
    for verb, text in VERBS.items():
        # A verb's module docstring is what its own --help says.
        module = importlib.import_module(
            f'ros_rops.cli.{verb.replace("-", "_")}') if verb == asked else None
        sub = verbs.add_parser(
            verb, help=text, description=module.__doc__ if module else None,
            formatter_class=argparse.RawDescriptionHelpFormatter)
        if module is not None:
            module.add_arguments(sub)
            sub.set_defaults(run=module.run)
    return parser


if __name__ == '__main__':
    raise SystemExit(main())
