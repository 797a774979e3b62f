# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Recall, precision and errors of a list of registered pairs (EVALUATION)."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from ros_rops.bench.contest import PairRecord, Prepared
from ros_rops.bench.evaluation import overlap_bin, OVERLAP_BINS


def share(part: int, whole: int) -> float | None:
    """Return part / whole, None where there is nothing to take a share of."""
    return part / whole if whole else None


def recall(records: Sequence[PairRecord]) -> float | None:
    """Return correct and accepted / evaluated pairs."""
    evaluated = [record for record in records if record.truth.evaluated]
    return share(sum(record.correct for record in evaluated), len(evaluated))


def precision(records: Sequence[PairRecord]) -> float | None:
    """Return correct and accepted / accepted, over all pairs given."""
    accepted = [record for record in records if record.accepted]
    return share(sum(record.correct for record in accepted), len(accepted))


def by_overlap(
    records: Sequence[PairRecord], score: Callable[[Sequence[PairRecord]], float | None]
) -> dict[str, float | None]:
    """Return a score of the pairs of each overlap bin."""
    return {
        key: score([record for record in records if overlap_bin(record.truth.overlap) == key])
        for key in OVERLAP_BINS
    }


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _name(record: PairRecord) -> list[str]:
    return [record.truth.name_i, record.truth.name_j]


def scores(records: Sequence[PairRecord], prepared: Prepared) -> dict[str, Any]:
    """
    Return the numbers of one set of pairs as plain JSON values.

    `rotation_deg`, `translation_dres` and the paper's `raw_translation_dres` are means over the
    correct pairs; `seconds_per_pair` is the mean of all pairs without preparation,
    `seconds_prepare` the mean of a view.
    """
    evaluated = [record for record in records if record.truth.evaluated]
    right = [record for record in records if record.correct]
    right_errors = [record.errors for record in right if record.errors is not None]
    wrong = [record for record in records if record.accepted and not record.correct]
    return {
        'pairs': len(evaluated),
        'pairs_all': len(records),
        'recall': recall(records),
        'precision': precision(records),
        'recall_by_overlap': by_overlap(records, recall),
        'precision_by_overlap': by_overlap(records, precision),
        'pairs_by_overlap': {
            key: sum(overlap_bin(r.truth.overlap) == key for r in records) for key in OVERLAP_BINS
        },
        'correct': sum(record.correct for record in evaluated),
        'accepted': sum(record.accepted for record in records),
        'wrong_accepted': [_name(record) for record in wrong],
        'missed': [_name(record) for record in evaluated if not record.correct],
        'rotation_deg': _mean([error.rotation_deg for error in right_errors]),
        'translation_dres': _mean([error.translation_dres for error in right_errors]),
        'raw_translation_dres': _mean([error.raw_translation_dres for error in right_errors]),
        'seconds_per_pair': _mean([record.seconds for record in records]),
        'seconds_prepare': _mean(list(prepared.seconds.values())),
        'seconds_per_pair_with_prepare': _mean([r.seconds_with_prepare for r in records]),
    }


def details(records: Sequence[PairRecord]) -> list[dict[str, Any]]:
    """Return every pair as plain JSON values."""
    return [
        {
            'source': record.truth.name_i,
            'target': record.truth.name_j,
            'overlap': record.truth.overlap,
            'status': record.status.value,
            'reason': record.reason,
            'correct': record.correct,
            'errors': None if record.errors is None else asdict(record.errors),
            'seconds': record.seconds,
            'numbers': dict(record.numbers),
        }
        for record in records
    ]
