# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run as the reports see it: a session, and the inputs that never became views."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ros_rops.core.config import Config


@dataclass(frozen=True, slots=True)
class Refusal:
    """An input that never became a view of the session, and why."""

    name: str
    reason: str


@dataclass(frozen=True, slots=True)
class Run:
    """
    A finished run.

    Parameters
    ----------
    session : Session
        Of `ros_rops.pipeline.session`, finished. What is read of it: `reports`, `objects`,
        `views`, `mesh_resolution`, `units`, `attempts`, `stage_seconds`, `trace`, `station`.
    config : Config
        The parameters it ran with.
    order : sequence of str
        Names of all inputs in order of arrival, the refused ones included.
    refusals : mapping of str to Refusal
        The inputs that could not be read, by name.
    facts : mapping
        What else `metrics.json` says: machine, versions, seconds, command.
    frames : mapping
        The content of `frames.json`; without, none is written.
    complete : bool
        Whether all of the input was read.
    """

    session: Any
    config: Config
    order: Sequence[str]
    refusals: Mapping[str, Refusal] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)
    frames: Mapping[str, Any] = field(default_factory=dict)
    complete: bool = True
