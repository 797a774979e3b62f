# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`--help` of the nodes' commands: what they do and which parameters they have."""

from collections.abc import Iterable, Sequence
import sys

from ros_rops.core.parameter import ParameterInfo
from ros_rops.pipeline.parameters import bounds_text, scalar_text

HELP = frozenset({'-h', '--help'})


def asked_for_help(args: Sequence[str] | None) -> bool:
    """Tell whether the words of a command (by default this process's) ask for help."""
    return bool(HELP.intersection(sys.argv[1:] if args is None else args))


def say_usage(command: str, what: str, infos: Iterable[ParameterInfo], more: str = '') -> None:
    """Write how a node's command is used to the terminal."""
    lines = [
        f'{command}: {what}', '',
        f'{command} --ros-args [-p NAME:=VALUE]... [--params-file FILE] [-r TOPIC:=OTHER]... '
        '[-r __ns:=NAMESPACE]', '', 'parameters (default; allowed):']
    for info in infos:
        allowed = ', '.join(text for text in (info.unit, bounds_text(info)) if text)
        default = scalar_text(info.default)
        lines.append(f'  {info.name} ({default}{"; " if allowed else ""}{allowed}): '
                     f'{info.description}')
    sys.stdout.write('\n'.join([*lines, *([more] if more else [])]) + '\n')
