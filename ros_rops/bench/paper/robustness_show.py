# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 6 and 8 shown: recall by level, what is kept of it, what falls short."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ros_rops.bench.evaluation import OVERLAP_BINS
from ros_rops.bench.experiment import Case
from ros_rops.bench.paper.drawing import drawing, saved
from ros_rops.bench.paper.engine_pairs import without_sets
from ros_rops.bench.paper.robustness import Disturbance, ENGINE, ROPS
from ros_rops.bench.scores import share
from ros_rops.bench.table import table

TOGETHER = 'together'


def measured(cases: Sequence[Case]) -> list[Case]:
    """Return the cases that are not about what is missing."""
    return [case for case in cases if 'missing' not in case]


def _engine(cases: Sequence[Case]) -> list[Case]:
    return [case for case in measured(cases) if case['by'] == ENGINE]


def _descriptors(cases: Sequence[Case]) -> list[Case]:
    return [case for case in measured(cases) if case['by'] != ENGINE]


def _names(cases: Sequence[Case], key: str) -> list[str]:
    return list(dict.fromkeys(case[key] for case in cases))


def sum_at(cases: Sequence[Case], level: float, key: str, overlap: str = '') -> int:
    """Add up counts of cases of a level, of one bin of overlap if given; of lists the lengths."""
    values = [case[key] for case in cases if case['level'] == level]
    return sum(
        len(one) if isinstance(one, list) else int(one[overlap] if overlap else one)
        for one in values)


def kept(cases: Sequence[Case], level: float, base: float) -> float | None:
    """Return the recall at a level / that of the undisturbed level."""
    now, before = (
        share(sum_at(cases, at, 'correct'), sum_at(cases, at, 'pairs')) for at in (level, base))
    return now / before if now is not None and before else None


def _mean(cases: Sequence[Case], level: float, key: str, weight: str) -> float | None:
    known = [
        (float(case[key]), int(case[weight])) for case in cases
        if case['level'] == level and case[key] is not None]
    total = sum(count for _, count in known)
    return sum(value * count for value, count in known) / total if total else None


def _recalls(name: str, cases: Sequence[Case], levels: Sequence[float], base: float) -> list[Any]:
    cells: list[Any] = [name]
    for level in levels:
        pairs = sum_at(cases, level, 'pairs')
        left = kept(cases, level, base)
        text = f'{sum_at(cases, level, "correct")}/{pairs}' if pairs else None
        cells.append(
            text if text is None or left is None or level == base else f'{text} ({left:.2f})')
    return cells


def show_robustness(cases: Sequence[Case], disturbance: Disturbance) -> str:
    """Return recall by set and level, the levels of all sets together, and the descriptors."""
    if any(set(case) == {'missing'} for case in cases):
        return 'Not measured.\n'
    levels, base = list(disturbance.labels), next(iter(disturbance.labels))
    labels, own = list(disturbance.labels.values()), _engine(cases)
    rows = [
        _recalls(name, [case for case in own if case['set'] == name], levels, base)
        for name in _names(own, 'set')]
    rows.append(_recalls(TOGETHER, own, levels, base))
    for row, name in enumerate(('must keep', 'should keep')):
        rows.append([name, *(
            f'{disturbance.asked[at][row]:g}' if at in disturbance.asked else None
            for at in levels)])
    text = table([disturbance.unit, *labels], rows)
    text += '\nAll sets together:\n\n' + table(
        [disturbance.unit, *OVERLAP_BINS, 'wrong', 'wrong without overlap', 'deg', 'dres',
         'keypoints', 'mr/dres', 'unprepared'],
        [_level_row(own, level, label) for level, label in disturbance.labels.items()])
    compared = [level for level in levels if level in disturbance.compared]
    others = _descriptors(cases)
    if others:
        text += f'\nFeatures alone, {", ".join(_names(others, "set"))}:\n\n' + table(
            ['descriptor', *(disturbance.labels[level] for level in compared), 'wrong'],
            [_descriptor_row(others, name, compared, base) for name in _names(others, 'by')])
    return f'{text}\nThe paper: {disturbance.paper}\n'


def _level_row(cases: Sequence[Case], level: float, label: str) -> list[Any]:
    refused = sum_at(cases, level, 'unprepared')
    return [
        label,
        *(f'{sum_at(cases, level, "correct_by_overlap", key)}/'
          f'{sum_at(cases, level, "pairs_by_overlap", key)}' for key in OVERLAP_BINS),
        f'{sum_at(cases, level, "wrong")} of {sum_at(cases, level, "pairs")}',
        f'{sum_at(cases, level, "wrong_sampled")} of {sum_at(cases, level, "sampled")}',
        _mean(cases, level, 'rotation_deg', 'correct'),
        _mean(cases, level, 'translation_dres', 'correct'),
        _whole(_mean(cases, level, 'keypoints', 'prepared')),
        _mean(cases, level, 'mr_dres', 'prepared'),
        f'{refused} of {refused + sum_at(cases, level, "prepared")}']


def _whole(value: float | None) -> int | None:
    return None if value is None else round(value)


def _descriptor_row(
    cases: Sequence[Case], name: str, levels: Sequence[float], base: float
) -> list[Any]:
    mine = [case for case in cases if case['by'] == name]
    wrong, pairs = (sum(sum_at(mine, at, key) for at in levels) for key in ('wrong', 'pairs'))
    return [*_recalls(name, mine, levels, base), f'{wrong} of {pairs}']


def robustness_notes(cases: Sequence[Case], disturbance: Disturbance) -> list[str]:
    """Say what is missing, which musts are missed, what was wrongly accepted, who is ahead."""
    said = [
        f'{case["by"]}: {case["missing"]}' if 'by' in case else str(case['missing'])
        for case in cases if 'missing' in case]
    if any(set(case) == {'missing'} for case in cases):
        return said
    own = _engine(cases)
    return [
        *without_sets(cases), *said, *_missed(own, disturbance), *_wrong(cases, disturbance),
        *_ahead(_descriptors(cases), disturbance)]


def _missed(cases: Sequence[Case], disturbance: Disturbance) -> Iterator[str]:
    base = next(iter(disturbance.labels))
    for level, (must, _) in disturbance.asked.items():
        groups = [
            (name, [case for case in cases if case['set'] == name])
            for name in _names(cases, 'set')]
        for name, group in [*groups, (TOGETHER, cases)]:
            left = kept(group, level, base)
            if left is not None and left < must:
                yield (
                    f'{name}: keeps {left:.3f} at {disturbance.labels[level]}, at least {must:g} '
                    'was asked.')


def _wrong(cases: Sequence[Case], disturbance: Disturbance) -> Iterator[str]:
    for case in measured(cases):
        pairs = [*case['wrong'], *case['wrong_sampled']]
        if pairs:
            names = ', '.join(f'{i} - {j}' for i, j in pairs)
            yield (
                f'{case["by"]}, {case["set"]}, {disturbance.labels[case["level"]]}: '
                f'{len(pairs)} wrong accepted: {names}.')


def _ahead(cases: Sequence[Case], disturbance: Disturbance) -> Iterator[str]:
    own = {case['level']: case['correct'] for case in cases if case['by'] == ROPS}
    for case in cases:
        lead = case['correct'] - own.get(case['level'], case['correct'])
        if lead > 0:
            yield (
                f'Features alone, {disturbance.labels[case["level"]]}: {case["by"]} has {lead} '
                f'more than {ROPS}.')


def plot_robustness(cases: Sequence[Case], path: Path, disturbance: Disturbance) -> None:
    """Draw recall by level: a line for each set, a dashed one for each descriptor."""
    levels, own, others = list(disturbance.labels), _engine(cases), _descriptors(cases)
    with drawing(columns=2) as (figure, axes):
        for axis, lines, key, style, title in (
                (axes[0, 0], own, 'set', '-', 'full verification'),
                (axes[0, 1], others, 'by', '--',
                 ', '.join(['features alone', *_names(others, 'set')]))):
            for name, marker in zip(_names(lines, key), _markers(), strict=False):
                mine = {case['level']: case for case in lines if case[key] == name}
                at = [level for level in levels if level in mine]
                axis.plot(
                    [levels.index(level) for level in at],
                    [100 * (share(mine[level]['correct'], mine[level]['pairs']) or 0.0)
                     for level in at], style, marker=marker, markersize=4, label=name)
            axis.set_title(title)
            axis.set_xticks(range(len(levels)), list(disturbance.labels.values()))
            axis.set_xlabel(disturbance.unit)
            axis.set_ylabel('correct, %')
            axis.set_ylim(0, 104)
            axis.set_xlim(-0.2, len(levels) - 0.8)
            if lines:
                axis.legend(frameon=False, fontsize=8, loc='center left', bbox_to_anchor=(1, 0.5))
        saved(figure, path)


def _markers() -> Iterator[str]:
    while True:
        yield from 'osv^Dx+'
