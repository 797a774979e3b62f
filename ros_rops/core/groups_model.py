# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the models: assembled cloud, surface, and how far they may be trusted."""

from dataclasses import dataclass

from ros_rops.core.errors import ParameterError
from ros_rops.core.parameter import Group, param

FORMATS = ('ply', 'stl', 'obj', 'glb')
"""Files that a surface can be written to."""


def formats_of(text: str) -> tuple[str, ...]:
    """
    Return the formats in a list with commas, each once.

    Raises
    ------
    ParameterError
        If one is none of `FORMATS`.
    """
    found = tuple(dict.fromkeys(
        word.strip().lower() for word in text.split(',') if word.strip()))
    for word in found:
        if word not in FORMATS:
            raise ParameterError(f'formats: {word!r} is none of {", ".join(FORMATS)}')
    return found


@dataclass(frozen=True, slots=True)
class ModelConfig(Group):
    """Model of an object from all of its views (IV-C)."""

    surface: str = param(
        'volume', 'How the surface is made: signed distances along the lines of sight (volume, '
        'Curless and Levoy 1996), watertight whatever was seen (poisson, screened; needs Open3D), '
        'or not at all (none).', choices=('volume', 'poisson', 'none'))
    voxel_mr: float = param(
        1.0, 'Edge of a voxel; raised, and said, where the volume would not fit memory_mb.',
        unit='mr', low=0.1, high=50.0)
    holes: str = param(
        'open', 'What no view saw stays open, or is filled and marked.',
        choices=('open', 'filled'))
    memory_mb: int = param(
        1000, 'Most memory of the volume of an object.', unit='MB', low=16, high=1000000)
    formats: str = param(
        'ply', 'Files of the surface, separated by commas: ply, stl, obj, glb.')
    cloud_mr: float = param(
        0.5, 'Points of the assembled cloud nearer to each other are merged.',
        unit='mr', low=0.0, high=50.0)
    view_ids: bool = param(
        False, 'Leave the assembled cloud unmerged: every point of every view, where it was '
        'measured, under the id of its view.')
    report_mb: int = param(
        12, 'Most size of report.html: what it shows of clouds and surfaces is thinned to fit.',
        unit='MB', low=1, high=500)

    def __post_init__(self) -> None:
        """Check the values, and the words of the list."""
        Group.__post_init__(self)  # slots leave no bare super()
        formats_of(self.formats)
