# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Names of views as the report shows them: long ones shortened to what tells them apart."""

from collections.abc import Collection, Sequence
from functools import lru_cache

LONGEST = 24
"""Letters of a name that is shown whole."""
HEAD = 8
"""Letters of a longer one that are kept of its beginning."""


@lru_cache(maxsize=8)
def short_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """
    Return the names, those longer than `LONGEST` without a part in which they do not differ.

    A topic's `/camera/depth/points@1700000001033312345` keeps where it begins, and the digits that
    differ from those of the other views. No two become the same.
    """
    for tail in range(LONGEST - HEAD - 1, max(map(len, names), default=0) + 1):
        short = tuple(_short(name, *_alike(name, names), tail) for name in names)
        if len(set(short)) == len(set(names)):
            return short
    return names


def _alike(name: str, names: Sequence[str]) -> tuple[int, int]:
    """Return how many letters the long names that begin as one does share, in front and behind."""
    long = {one for one in names if len(one) > LONGEST and one[:HEAD] == name[:HEAD]}
    if len(long) < 2:
        return len(name), 0
    front = _common(long)
    return front, _common([one[front:][::-1] for one in long])


def _common(words: Collection[str]) -> int:
    """Return how many letters all words begin with."""
    low, high = min(words), max(words)
    return next((k for k, (a, b) in enumerate(zip(low, high, strict=False)) if a != b), len(low))


def _short(name: str, front: int, behind: int, tail: int) -> str:
    if len(name) <= max(LONGEST, HEAD + 1 + tail):
        return name
    end = len(name)
    if end - front > tail:
        # What differs does not reach the end: show it from where it begins.
        end = max(min(front + tail - 3, end), min(end - behind, front + tail))
    begin = max(end - tail, HEAD)
    return name[:HEAD] + '…' + name[begin:end] + ('…' if end < len(name) else '')
