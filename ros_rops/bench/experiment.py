# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""An experiment of the laboratory: what it runs on, what it measures, how its result is shown."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ros_rops.bench.evaluation import evaluate_pairs, PairTruth
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.recordings.synthetic import Model

# One line of a result as plain JSON values: what was measured, on what, by whom.
Case = Mapping[str, Any]
Kept = TypeVar('Kept')


@dataclass(frozen=True, slots=True)
class Laboratory:
    """
    What experiments run on.

    Parameters
    ----------
    sets : tuple of ReferenceSet
        Real views with reference poses.
    models : tuple of Model
        Meshes to render views from, whose poses are exact then.
    config : Config
        Of the engine; rivals take from it what they share with it.
    threads : int
        0 takes all cores.
    seed : int
        Of everything random: orders, noise, rivals' samples.
    repeats : int
        How often what is timed is run; medians count.
    tell : callable
        Told the progress.
    folders : mapping of str to Path
        Where each set was read from, by its name.
    """

    sets: tuple[ReferenceSet, ...]
    models: tuple[Model, ...]
    config: Config
    threads: int = 0
    seed: int = 0
    repeats: int = 1
    tell: Callable[[str], None] = lambda text: None
    folders: Mapping[str, Path] = field(default_factory=dict)
    _pairs: dict[str, list[PairTruth]] = field(default_factory=dict)
    _kept: dict[str, Any] = field(default_factory=dict)

    def once(self, key: str, make: Callable[[], Kept]) -> Kept:
        """Return what `make` gives, made at the first call with this key and kept."""
        if key not in self._kept:
            self._kept[key] = make()
        kept: Kept = self._kept[key]
        return kept

    def pairs(self, dataset: ReferenceSet) -> list[PairTruth]:
        """Return all pairs i < j of a set with their truth, worked out once."""
        if dataset.name not in self._pairs:
            self.tell(f'{dataset.name}: overlaps')
            self._pairs[dataset.name] = evaluate_pairs(dataset)
        return self._pairs[dataset.name]


@dataclass(frozen=True, slots=True)
class Experiment:
    """
    One table or figure.

    Parameters
    ----------
    name : str
        As given to `--only`; also the name of its file of results.
    title : str
        Heading in BENCHMARKS.md.
    about : str
        Markdown before the table: what was done, how a number is meant.
    run : callable
        Measures; returns the lines of the result, JSON values only.
    show : callable
        Lines of a result to Markdown, the paper's values beside ours; needs nothing else, so
        that a stored result can be shown again.
    plot : callable or None
        (lines, path of an SVG file to write).
    notes : callable or None
        (lines) to sentences on what is missing or falls short, each shown as a list item.
    """

    name: str
    title: str
    about: str
    run: Callable[[Laboratory], list[dict[str, Any]]]
    show: Callable[[Sequence[Case]], str]
    plot: Callable[[Sequence[Case], Path], None] | None = None
    notes: Callable[[Sequence[Case]], list[str]] | None = None
