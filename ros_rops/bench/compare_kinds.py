# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the numbers of a result mean, by their names: what is judged, which way is good."""

from collections.abc import Collection
from enum import Enum


class Kind(Enum):
    """What a number is."""

    PARAMETER = 'parameter'  # tells cases apart
    WRONG = 'wrong'          # wrong answers: each one counts
    RIGHT = 'right'          # right answers
    SHARE = 'share'          # of 1, more is better
    COST = 'cost'            # work done, counted
    ERROR = 'error'          # distances and angles
    SECONDS = 'seconds'
    MEMORY = 'memory'
    OTHER = 'other'          # not judged


# Runs of one case that differ by these alone are repeats of it.
REPEATS = ('seed', 'order', 'sequence', 'repeat')
_PARAMETERS = {
    'seed', 'order', 'repeat', 'k', 'n', 'views', 'objects', 'pairs', 'pairs_all', 'iterations',
    'fraction', 'level', 'number', 'samples', 'threads', 'possible'}
_PARAMETER_STARTS = ('noise', 'threshold', 'must', 'aim', 'limit', 'radius', 'voxel', 'bin')
# Strings that say how it went, not what was done.
OUTCOMES = {
    'reason', 'status', 'reached', 'error', 'missing', 'note', 'command',
    'translation_measured_at'}
_NOT_JUDGED = {
    'paper', 'ratio', 'p90', 'p99', 'worst', 'evaluated', 'must', 'aim', 'bias', 'numbers',
    'machine', 'reference', 'exponent', 'budget', 'told'}
# Shorter forms of what is there in full: the first key, if there, makes the others superfluous.
_IN_FULL = (
    ('details', (
        'correct', 'recall', 'precision', 'recall_by_overlap', 'precision_by_overlap', 'accepted',
        'missed', 'rotation_deg', 'translation_dres', 'raw_translation_dres', 'seconds_per_pair',
        'seconds_per_pair_with_prepare')),
    ('errors', ('mean_rotation_deg', 'mean_translation_dres')),
    ('wrong_views', ('wrong_placements',)),
    ('wrong_accepted', ('wrong',)),
    ('correct', ('recall', 'accepted', 'missed')),
    ('right', ('right_of_all', 'right_of_possible')),
    ('median_ms', ('p90_ms',)),
    ('seconds', ('seconds_add', 'seconds_finish')),
)
_WORDS = {
    Kind.WRONG: {'wrong', 'merges', 'splits', 'merged', 'split', 'false', 'folded'},
    Kind.RIGHT: {'correct', 'placed', 'right'},
    Kind.SHARE: {'recall', 'precision', 'completeness', 'auc'},
    Kind.COST: {'attempts', 'registrations'},
    Kind.SECONDS: {'seconds', 's', 'ms'},
    Kind.MEMORY: {'mib'},
    Kind.ERROR: {'deg', 'dres', 'residual', 'accuracy'},
}


def kind_of(name: str) -> Kind:
    """
    Return the kind of a number from its name.

    >>> kind_of('wrong_placements'), kind_of('seconds_per_pair'), kind_of('noise_dres')
    (<Kind.WRONG: 'wrong'>, <Kind.SECONDS: 'seconds'>, <Kind.PARAMETER: 'parameter'>)
    """
    if name in _PARAMETERS or name.startswith(_PARAMETER_STARTS):
        return Kind.PARAMETER
    words = set(name.lower().split('_'))
    if words & _NOT_JUDGED or name == 'dres':
        return Kind.OTHER
    return next((kind for kind, known in _WORDS.items() if words & known), Kind.OTHER)


def kind_at(path: tuple[str, ...]) -> Kind:
    """Return the kind of a number inside of others: the innermost name that says one."""
    if any(_NOT_JUDGED & set(name.lower().split('_')) for name in path):
        return Kind.OTHER
    kinds = (kind_of(name) for name in reversed(path))
    return next((k for k in kinds if k not in (Kind.OTHER, Kind.PARAMETER)), Kind.OTHER)


def superfluous(names: Collection[str]) -> set[str]:
    """Return which entries of a case only repeat what other entries of it say in full."""
    return {short for full, shorts in _IN_FULL if full in names for short in shorts}
