# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Every parameter, once: default, bounds, unit and one sentence.

YAML, ROS declarations, `--help` and the README's table are derived from the dataclasses of
`groups_station`, `groups_features`, `groups_pairing`, `groups_growth` and `groups_model`.
Lengths of the algorithm are in mesh resolutions (suffix `_mr`), those of the station in metres
(`_m`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ros_rops.core.groups_features import KeypointConfig, LrfConfig, MeshConfig, RopsConfig
from ros_rops.core.groups_growth import FineConfig, GrowthConfig
from ros_rops.core.groups_model import ModelConfig
from ros_rops.core.groups_pairing import (
    CcvConfig, EvidenceConfig, IcpConfig, MatchingConfig, PairwiseConfig, VerdictConfig)
from ros_rops.core.groups_station import PriorConfig, SegmentationConfig, SelectionConfig
from ros_rops.core.parameter import (
    describe_groups, ParameterInfo, Scalar, values_of, with_values)

__all__ = [
    'Config', 'describe', 'MeshConfig', 'KeypointConfig', 'LrfConfig', 'RopsConfig',
    'MatchingConfig', 'CcvConfig', 'IcpConfig', 'EvidenceConfig', 'PairwiseConfig',
    'VerdictConfig', 'GrowthConfig', 'FineConfig', 'SegmentationConfig', 'SelectionConfig',
    'PriorConfig', 'ModelConfig',
]


@dataclass(frozen=True, slots=True)
class Config:
    """All parameters, by group: the station's first, then the engine's, then the models'."""

    selection: SelectionConfig = SelectionConfig()
    segmentation: SegmentationConfig = SegmentationConfig()
    prior: PriorConfig = PriorConfig()
    mesh: MeshConfig = MeshConfig()
    keypoints: KeypointConfig = KeypointConfig()
    lrf: LrfConfig = LrfConfig()
    rops: RopsConfig = RopsConfig()
    matching: MatchingConfig = MatchingConfig()
    ccv: CcvConfig = CcvConfig()
    icp: IcpConfig = IcpConfig()
    evidence: EvidenceConfig = EvidenceConfig()
    pairwise: PairwiseConfig = PairwiseConfig()
    verdict: VerdictConfig = VerdictConfig()
    growth: GrowthConfig = GrowthConfig()
    fine: FineConfig = FineConfig()
    model: ModelConfig = ModelConfig()

    @classmethod
    def from_flat(cls, values: Mapping[str, object]) -> 'Config':
        """
        Make a configuration from dotted names, the rest at their defaults.

        Parameters
        ----------
        values : mapping
            For example ``{'rops.radius_mr': 12.0}``.

        Raises
        ------
        ParameterError
            For an unknown name, a wrong type or a value out of bounds.
        """
        config: Config = with_values(cls(), values)
        return config

    def to_flat(self) -> dict[str, Scalar]:
        """Return all values by dotted name, in the order of declaration."""
        return values_of(self)


def describe() -> Iterator[ParameterInfo]:
    """Yield every parameter by dotted name, in the order of declaration."""
    yield from describe_groups(Config)
