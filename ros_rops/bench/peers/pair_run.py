# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""All pairs of a set by one contestant, several rounds, in a process of its own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.bench.contest import (
    Contestant, errors_in, PairRecord, prepare_all, Prepared, run_pairs)
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.machine import peak_rss_mib, usable_cores
from ros_rops.bench.peers.apart import run_apart
from ros_rops.bench.peers.roster import Peer, ROSTER
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config

# Imported before the first view, so that the memory of libraries is told apart.
OUR_MODULES = ('ros_rops.core.pairwise', 'ros_rops.pipeline.prepare')


@dataclass(frozen=True, slots=True)
class PairJob:
    """What one contestant is to do; 0 `threads` take all cores."""

    peer: str
    dataset: ReferenceSet
    pairs: tuple[PairTruth, ...]
    config: Config
    threads: int
    repeats: int


@dataclass(frozen=True, slots=True)
class PairRounds:
    """
    What became of it.

    Parameters
    ----------
    records : tuple of tuple of PairRecord
        Of each round, in the order of the pairs.
    prepared : tuple of tuple of float
        Seconds of each view, of each round.
    peak_rss_mib : float
    libraries_mib : float
        Of it, before there were data.
    """

    records: tuple[tuple[PairRecord, ...], ...]
    prepared: tuple[tuple[float, ...], ...]
    peak_rss_mib: float
    libraries_mib: float = 0.0

    def seconds(self) -> list[float]:
        """Return the median over the rounds of every pair, both views prepared for it."""
        return _medians([[one.seconds_with_prepare for one in r] for r in self.records])

    def seconds_of_pairs(self) -> list[float]:
        """Return the median over the rounds of every pair, preparation left out."""
        return _medians([[one.seconds for one in r] for r in self.records])

    def seconds_of_views(self) -> list[float]:
        """Return the median over the rounds of preparing every view."""
        return _medians(self.prepared)


def _medians(rounds: Sequence[Sequence[float]]) -> list[float]:
    return [float(value) for value in np.median(np.array(rounds, dtype=float), axis=0)]


def run_job(job: PairJob) -> PairRounds:
    """Run all rounds, after a pair that warms up."""
    contestant = ROSTER[job.peer].make(
        job.dataset.dres, job.config, job.threads or usable_cores())
    _warm_up(contestant, job)
    records, prepared = [], []
    for _ in range(job.repeats):
        views: Prepared = prepare_all(contestant, job.dataset.views, _silent)
        records.append(tuple(run_pairs(
            contestant, job.pairs, views, errors_in(job.dataset), _silent)))
        prepared.append(tuple(views.seconds.values()))
    return PairRounds(tuple(records), tuple(prepared), peak_rss_mib())


def _warm_up(contestant: Contestant, job: PairJob) -> None:
    pair = job.pairs[0]
    contestant.register(*(
        contestant.prepare(job.dataset.views[name]) for name in (pair.name_i, pair.name_j)))


def _silent(text: str) -> None:
    pass


def run_peer(peer: Peer, job: PairJob) -> PairRounds:
    """Run a contestant apart."""
    rounds, libraries = run_apart(
        run_job, job, modules=peer.needs or OUR_MODULES, threads=job.threads)
    return PairRounds(rounds.records, rounds.prepared, rounds.peak_rss_mib, libraries)
