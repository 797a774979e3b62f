# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the intake says of every frame or file that came in."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
import re
from types import MappingProxyType
from typing import Any

from ros_rops.pipeline.reports import ViewReport


class Word(Enum):
    """What became of a frame."""

    TAKEN = 'taken'
    SKIPPED = 'skipped'
    EMPTY = 'empty'
    BAD = 'bad'


@dataclass(frozen=True, slots=True)
class FrameReport:
    """
    The word on a frame, or on a file that holds a view.

    Parameters
    ----------
    name : str
        Unique within a session.
    word : Word
        TAKEN (it gave views), SKIPPED (not selected), EMPTY (selected, but no object was found in
        it) or BAD (cannot be read).
    reason : str
        One sentence; of a file that is a view as it stands, empty.
    views : tuple of str
        Names of the views that it gave.
    notes : tuple of str
        What had to be inferred to read it.
    numbers : mapping of str to float
        What the selection rests on.
    reports : tuple of ViewReport
        The session's word on the views when they arrived; later views may change it.
    """

    name: str
    word: Word
    reason: str = ''
    views: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    reports: tuple[ViewReport, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return all but `reports` in JSON's own types."""
        return {
            'name': self.name, 'word': self.word.value, 'reason': self.reason,
            'views': list(self.views), 'notes': list(self.notes),
            'numbers': {key: float(value) for key, value in self.numbers.items()},
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> 'FrameReport':
        """
        Return what `to_json` was called on.

        Raises
        ------
        KeyError, TypeError, ValueError
            If the content is not of that form.
        """
        return cls(
            str(content['name']), Word(content['word']), str(content['reason']),
            tuple(map(str, content['views'])), tuple(map(str, content['notes'])),
            {str(key): float(value) for key, value in content['numbers'].items()})


Counts = Mapping[Word, Mapping[str, int]]
"""How many frames have a word, by reason."""


def count_words(
    frames: Iterable[FrameReport], more: Counts = MappingProxyType({})
) -> dict[str, Any]:
    """
    Count frames by word, and those without views by reason.

    Parameters
    ----------
    frames : iterable of FrameReport
    more : mapping
        Frames without views of which no report is kept.

    Returns
    -------
    dict
        ``read`` (all), ``taken``, ``views`` (of those taken), ``skipped``, ``empty``, ``bad``,
        and ``reasons``: by word, how often each reason was given, its figures left out.
    """
    words: Counter[Word] = Counter()
    reasons: dict[Word, Counter[str]] = {
        word: Counter() for word in (Word.SKIPPED, Word.EMPTY, Word.BAD)}
    views = 0
    for frame in frames:
        words[frame.word] += 1
        views += len(frame.views)
        if frame.word in reasons:
            reasons[frame.word][without_figures(frame.reason)] += 1
    for word, counts in more.items():
        words[word] += sum(counts.values())
        reasons[word].update(counts)
    return {
        'read': words.total(), 'taken': words[Word.TAKEN], 'views': views,
        **{word.value: words[word] for word in reasons},
        'reasons': {word.value: dict(counts) for word, counts in reasons.items() if counts},
    }


def frames_document(
    frames: Sequence[FrameReport], more: Counts = MappingProxyType({})
) -> dict[str, Any]:
    """
    Return the content of `frames.json`: the counts, and the word on every frame in order.

    Frames of which no report is kept (`more`) are in the counts only.
    """
    return {'counts': count_words(frames, more), 'frames': [frame.to_json() for frame in frames]}


def without_figures(text: str) -> str:
    """
    Return `text` with '#' for every number, so that reasons that say the same are the same.

    Digits that end a word are part of a name, as in `tf2_msgs` and `PointCloud2`.
    """
    return re.sub(r'(?<![A-Za-z_]{2})(?<!\d)[-+]?\d[\d.e+-]*', '#', text)
