# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Models and report of a saved run, made in a process of their own.

The libraries that make a surface keep Python from running for seconds, and take gigabytes: the
station must not wait for them, nor end with them. Started by `live.modeller`, which hands over
what models are made of on standard input; a line of JSON on standard output tells what is done.
"""

from contextlib import suppress
import ctypes
import json
import os
from pathlib import Path
import pickle
import signal
import sys
import threading
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from ros_rops.reporting.models import ModelTask

LIKELIER = '500'
"""Where memory runs out, the system ends this process before others."""
NAME = b'rops_models'
"""In lists of processes; 15 bytes at most."""
PR_SET_PDEATHSIG, PR_SET_NAME = 1, 15


def main() -> int:
    """
    Make what standard input asks for; return the exit code.

    On the command line are the folder, for those who look at the list of processes, and how far
    it gives way.
    """
    with suppress(OSError):
        Path('/proc/self/oom_score_adj').write_text(LIKELIER, encoding='ascii')
    _be_known()
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, int(sys.argv[2]))
    # What has to be imported for it takes a second of a core: not before it gives way.
    order = pickle.load(sys.stdin.buffer)
    # Whoever asked holds the other end; without them the folder may be another's already.
    threading.Thread(target=_end_with_the_other_side, daemon=True).start()
    notes = _models(order['folder'], order['task']) if order['models'] else ()
    if order['report']:
        notes = (*notes, *_report(order['folder']))
    _tell(done=list(notes))
    return 0


def _be_known() -> None:
    """Have a name, and end with the other side at once; on Linux."""
    with suppress(OSError, AttributeError):
        prctl = ctypes.CDLL(None).prctl
        prctl(PR_SET_NAME, NAME, 0, 0, 0)
        # A library that keeps Python from running keeps the thread below from it too. The thread
        # of the other side that counts waits for this process, and so does not end before.
        prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)


def _models(folder: Path, task: 'ModelTask') -> tuple[str, ...]:
    from ros_rops.reporting.models import make_models

    return make_models(folder, task, say=lambda text: _tell(doing=text)).notes


def _report(folder: Path) -> tuple[str, ...]:
    from ros_rops.reporting.report import write_report

    _tell(doing='writing the report')
    try:
        write_report(folder)
    except Exception as error:  # the models stand
        return (f'no report: {error} ({type(error).__name__})',)
    return ()


def _end_with_the_other_side() -> None:
    # Nothing comes any more: it returns when the other side has gone. From the handle itself, so
    # that nobody holds the stream's lock when the process ends.
    while os.read(sys.stdin.fileno(), 1):
        pass
    os._exit(1)


def _tell(**what: Any) -> None:
    sys.stdout.write(json.dumps(what) + '\n')
    sys.stdout.flush()


if __name__ == '__main__':
    raise SystemExit(main())
