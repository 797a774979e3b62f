# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A rival strategy for many views: which pairs are registered, and how they become objects."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ros_rops.bench.multiview import Job


@dataclass(frozen=True, slots=True)
class Strategy:
    """
    A way from unordered views to objects.

    Parameters
    ----------
    name : str
    source : str
        Where it was published.
    open_session : callable
        A job to what has the methods and attributes of `Session` that `run_job` uses; a function
        of a module, since jobs run in processes of their own.
    """

    name: str
    source: str
    open_session: Callable[[Job], Any]
