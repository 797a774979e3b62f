# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of a rigid transform against its reference (Guo et al. 2014, eqs. 9-11)."""

from dataclasses import dataclass
import math

import numpy as np
from ros_rops.core.types import Floats

CORRECT_DEG = 5.0
CORRECT_DRES = 5.0


@dataclass(frozen=True, slots=True)
class PairErrors:
    """
    Errors of one estimated transform.

    Parameters
    ----------
    rotation_deg : float
        Angle between estimate and reference (eq. 9).
    translation_dres : float
        Distance between the source view's centroid mapped by the estimate and by the
        reference, over dres.
    raw_translation_dres : float
        The paper's eq. 11: the translation vectors compared as they are, over dres.
    """

    rotation_deg: float
    translation_dres: float
    raw_translation_dres: float

    @property
    def correct(self) -> bool:
        """Whether both errors are below 5 degrees and 5 dres."""
        return self.rotation_deg < CORRECT_DEG and self.translation_dres < CORRECT_DRES


def rotation_error_deg(rotation: Floats, reference: Floats) -> float:
    """
    Angle in degrees between two rotations (3, 3), eq. 9.

    From the sine and the cosine both: the arc cosine alone loses half of the digits near 0.
    """
    difference = reference @ rotation.T
    axis = difference - difference.T
    sine = math.sqrt(float((axis * axis).sum())) / (2.0 * math.sqrt(2.0))
    cosine = (float(np.trace(difference)) - 1.0) / 2.0
    return math.degrees(math.atan2(sine, cosine))


def pair_errors(
    T_estimate: Floats, T_reference: Floats, centroid: Floats, dres: float
) -> PairErrors:
    """
    Compare two transforms (4, 4) of the same direction.

    Parameters
    ----------
    T_estimate, T_reference : (4, 4) float64
        `T_target_source`, in the units of `dres`.
    centroid : (3,) float64
        Mean of the source view's points, in the source frame.
    dres : float
        Mesh resolution of the data set.
    """
    difference = T_estimate - T_reference
    at_centroid = difference[:3, :3] @ centroid + difference[:3, 3]
    return PairErrors(
        rotation_deg=rotation_error_deg(T_estimate[:3, :3], T_reference[:3, :3]),
        translation_dres=float(np.linalg.norm(at_centroid)) / dres,
        raw_translation_dres=float(np.linalg.norm(difference[:3, 3])) / dres,
    )
