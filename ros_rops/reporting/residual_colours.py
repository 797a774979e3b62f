# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The colours of residuals: the same in `object_<k>_residuals.ply` and in the report.

`assets/viewer.js` has them too, since a shader needs them; a test compares.
"""

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes

SHADES = np.array([(49, 54, 149), (116, 173, 209), (255, 255, 191), (244, 109, 67),
                   (165, 0, 38)], np.float64)
"""
From behind to in front of what the others saw (ColorBrewer's RdYlBu).

Safe for the colour-blind; pale yellow and not white or grey lies in the middle, which a shaded
point of no residual has.
"""
ALONE = (140, 140, 148)
AGAINST = (200, 0, 200)
MOST_WITHIN = 0.9
"""Of the residuals, that the scale has colours of their own for."""
STEPS = (1.0, 2.0, 3.0, 5.0, 10.0)


def reach_of(residual: NDArray[np.float32], state: Bytes | None) -> float:
    """
    Return the residual that has the last colour: a round number beyond most of them.

    Parameters
    ----------
    residual : (N,) float32
    state : (N,) uint8 or None
        Those contradicted (2) have a colour of their own and do not count.
    """
    counted = np.isfinite(residual)
    if state is not None and (counted & (state != 2)).any():
        counted &= state != 2
    sizes = np.abs(residual[counted].astype(np.float64))
    most = float(np.quantile(sizes, MOST_WITHIN)) if len(sizes) else 0.0
    if most <= 0:
        return 1.0
    base = 10.0 ** np.floor(np.log10(most))
    # With as many digits as a step has: 0.0003, not 0.00030000000000000003.
    return float(f'{base * next(step for step in STEPS if step * base >= 0.999 * most):.1e}')


def residual_colors(residual: NDArray[np.float32], state: Bytes, reach: float) -> Bytes:
    """
    Return the colours of residuals.

    Parameters
    ----------
    residual : (N,) float32
        Signed, positive in front of what the other views saw.
    state : (N,) uint8
        0: alone. 2: contradicted.
    reach : float
        The residual of the last colours: blue behind and red in front.

    Returns
    -------
    (N, 3) uint8
    """
    known = np.isfinite(residual)
    place = np.clip(np.where(known, residual, 0.0) / reach, -1.0, 1.0)
    at = (place + 1.0) / 2.0 * (len(SHADES) - 1)
    below = np.minimum(at.astype(int), len(SHADES) - 2)
    part = (at - below)[:, None]
    colors = np.rint(SHADES[below] * (1.0 - part) + SHADES[below + 1] * part)
    colors[~known | (state == 0)] = ALONE
    colors[state == 2] = AGAINST
    shades: Bytes = colors.astype(np.uint8)
    return shades
