# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The cases by name; `rops bench` and `python -m ros_rops.bench` offer exactly these."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from ros_rops.bench import (
    ablation, compare, feature_quality, model, multiview, pairwise, recordings, short, station,
    stored, synthetic, turntable)
from ros_rops.bench.paper import case as paper
from ros_rops.bench.peers import case as peers
from ros_rops.bench.scaling import case as scaling


@dataclass(frozen=True, slots=True)
class Case:
    """One case: its line of `--help`, its options, and what runs it (returns the exit code)."""

    summary: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]


CASES = {
    'pairwise': Case(
        'every pair of views by itself: recall, precision, errors, seconds',
        pairwise.add_arguments, pairwise.run),
    'multiview': Case(
        'unordered views of one or several objects through a session',
        multiview.add_arguments, multiview.run),
    'model': Case(
        'surfaces of registered views against reference meshes: accuracy, completeness, seconds',
        model.add_arguments, model.run),
    'synthetic': Case(
        'views rendered from a mesh, poses exact, with noise, through a session',
        synthetic.add_arguments, synthetic.run),
    'turntable': Case(
        'a simulated station: recorded, read back, through a session; poses exact',
        turntable.add_arguments, turntable.run),
    'recordings': Case(
        'milliseconds from a message to a view, stage by stage',
        recordings.add_arguments, recordings.run),
    'station': Case(
        'the registration node over the wire: start, latency, services, a stream of frames',
        station.add_arguments, station.run),
    'descriptor': Case(
        'how often the nearest feature of the other view is the right one',
        feature_quality.add_arguments, feature_quality.run),
    'paper': Case(
        'the tables and figures of Guo et al. 2014 on these data, with rivals',
        paper.add_arguments, paper.run),
    'ablation': Case(
        "each choice of ours exchanged for the paper's, one at a time",
        ablation.add_arguments, ablation.run),
    'short': Case(
        "a minute's measurement of everything, held against a stored one",
        short.add_arguments, short.run),
    'compare': Case(
        'what became better or worse, beyond noise, from one file of results to another',
        compare.add_arguments, compare.run),
    'peers': Case(
        'other programs on the same pairs and views in the same run',
        peers.add_arguments, peers.run),
    'scaling': Case(
        'growth of time, memory and registrations with views and with objects',
        scaling.add_arguments, scaling.run),
    'document': Case(
        'stored results into the sections of BENCHMARKS.md',
        stored.add_arguments, stored.run),
}
