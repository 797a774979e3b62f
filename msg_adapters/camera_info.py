# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
sensor_msgs/CameraInfo to the rays of a camera's pixels, by attribute names only.

Distortion is that of ROS (REP 104 and OpenCV): `plumb_bob`, `rational_polynomial` (thin prism
included) and `equidistant`. It is inverted once per camera.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from msg_adapters.attributes import attribute, whole
import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError

KIND = 'CameraInfo'
MODELS = {'plumb_bob': (4, 5), 'rational_polynomial': (8, 12, 14), 'equidistant': (4,)}
"""How many coefficients each model may have."""
ROUNDS = 100
"""Most rounds of the inversion; a strong lens needs 20."""
MISFIT_PX = 0.05
"""A ray is sound if it meets its pixel within this."""
LARGEST_PIXELS = 2**27
"""More pixels than any camera has: refused before memory is taken for their rays."""

Rays = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Calibration:
    """
    What of a CameraInfo the rays of an image depend on; equal calibrations share their rays.

    Parameters
    ----------
    height, width : int
        Of the image, after region of interest and binning.
    fx, fy, cx, cy : float
        In pixels of that image.
    model : str
        '' without distortion, else one of `MODELS`.
    distortion : tuple of float
    """

    height: int
    width: int
    fx: float
    fy: float
    cx: float
    cy: float
    model: str = ''
    distortion: tuple[float, ...] = ()


def calibration(info: Any, height: int, width: int, *, rectified: bool = False) -> Calibration:
    """
    Return the calibration of an image that came with a CameraInfo.

    Parameters
    ----------
    info : object
        Has CameraInfo's attributes, in ROS 2's spelling (k, d, p) or in ROS 1's (K, D, P).
    height, width : int
        Of the image.
    rectified : bool
        Whether the image is undistorted already: then P describes it, else K and D do.

    Raises
    ------
    InputError
        If the camera is not calibrated, its distortion model is unknown, or the image is not of
        the size that the calibration is for.
    """
    offset, binning = _window(info, height, width)
    projection, k = _numbers(info, 'p', 12), _numbers(info, 'k', 9)
    chosen = (projection[0], projection[5], projection[2], projection[6])
    if k[0] and not (rectified and projection[0]):
        chosen = (k[0], k[4], k[2], k[5])
    fx, fy, cx, cy = chosen
    if not (np.isfinite(chosen).all() and fx > 0 and fy > 0):
        raise InputError(f'CameraInfo: focal lengths {fx:g} and {fy:g}: the camera is not '
                         'calibrated')
    model, distortion = ('', ()) if rectified else _distortion(info)
    return Calibration(
        height, width, fx / binning[0], fy / binning[1], (cx - offset[0]) / binning[0],
        (cy - offset[1]) / binning[1], model, distortion)


def _numbers(info: Any, name: str, count: int) -> list[float]:
    spelled = name if hasattr(info, name) else name.upper()
    try:
        values = [float(value) for value in attribute(info, spelled, KIND)]
    except (TypeError, ValueError, OverflowError):
        raise InputError(f'CameraInfo: {spelled} is no sequence of numbers') from None
    if count and len(values) != count:
        raise InputError(f'CameraInfo: {spelled} has {len(values)} numbers, not {count}')
    return values


def _window(info: Any, height: int, width: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the offset (x, y) of the image in the sensor's, and its binning (x, y)."""
    roi = attribute(info, 'roi', KIND)
    binning = (max(whole(info, 'binning_x', KIND), 1), max(whole(info, 'binning_y', KIND), 1))
    full = whole(info, 'width', KIND), whole(info, 'height', KIND)
    part = whole(roi, 'width', KIND), whole(roi, 'height', KIND)
    offset = whole(roi, 'x_offset', KIND), whole(roi, 'y_offset', KIND)
    if 0 in part:
        part, offset = full, (0, 0)
    expected = part[0] // binning[0], part[1] // binning[1]
    # Some drivers leave the size at 0; then there is nothing to contradict.
    if 0 not in full and expected != (width, height):
        raise InputError(f'CameraInfo: made for images of {expected[0]} x {expected[1]} pixels, '
                         f'the image has {width} x {height}')
    return offset, binning


def _distortion(info: Any) -> tuple[str, tuple[float, ...]]:
    values = _numbers(info, 'd', 0)
    if not any(values):
        return '', ()
    model = str(attribute(info, 'distortion_model', KIND))
    if model not in MODELS:
        raise InputError(f'CameraInfo: distortion model {model!r} is none of {", ".join(MODELS)}')
    # Some drivers name the eight of a rational polynomial, or pad with zeros.
    while values and len(values) > min(MODELS[model]) and values[-1] == 0:
        values.pop()
    longest = max(MODELS[model])
    if not np.isfinite(values).all() or not min(MODELS[model]) <= len(values) <= longest:
        raise InputError(f'CameraInfo: {len(values)} coefficients of {model!r}: '
                         f'{", ".join(map(str, MODELS[model]))} finite ones expected')
    if any(values[12:]):
        raise InputError('CameraInfo: a tilted sensor (coefficients 13 and 14) is not supported')
    return model, tuple(values)


@lru_cache(maxsize=8)
def rays(camera: Calibration) -> tuple[Rays, Rays, NDArray[np.bool_] | None]:
    """
    Return x / z and y / z of every pixel's ray and which pixels have none, each (H, W).

    The arrays are read-only; the last is None where every pixel has a ray.

    Raises
    ------
    InputError
        If the image is larger than any camera's.
    """
    if camera.height * camera.width > LARGEST_PIXELS:
        raise InputError(f'image of {camera.width} x {camera.height} pixels: no camera has that')
    v, u = np.mgrid[:camera.height, :camera.width].astype(np.float64)
    with np.errstate(all='ignore'):  # absurd focal lengths end as pixels without a ray
        x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    if camera.model == 'equidistant':
        x, y = _unfold(x, y, camera.distortion)
    elif camera.model:
        x, y = _straighten(x, y, camera)
    with np.errstate(over='ignore'):
        x32, y32 = x.astype(np.float32), y.astype(np.float32)
    lost = ~(np.isfinite(x32) & np.isfinite(y32))
    for array in (x32, y32, lost):
        array.flags.writeable = False
    return x32, y32, lost if lost.any() else None


def _straighten(
    x: NDArray[np.float64], y: NDArray[np.float64], camera: Calibration
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Invert the polynomial lens by iteration; pixels that it does not reach become NaN."""
    far_x, far_y = x, y
    with np.errstate(all='ignore'):
        for _ in range(ROUNDS):
            seen_x, seen_y = distort(x, y, camera.distortion)
            error_x, error_y = far_x - seen_x, far_y - seen_y
            x, y = x + error_x, y + error_y
            miss = np.hypot(error_x * camera.fx, error_y * camera.fy)
            if not (miss > MISFIT_PX / 50).any():
                break
        lost = ~(miss <= MISFIT_PX)
    x[lost] = y[lost] = np.nan
    return x, y


def distort(
    x: NDArray[np.float64], y: NDArray[np.float64], coefficients: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Return where a lens puts the rays x / z, y / z, in focal lengths from the centre.

    Parameters
    ----------
    x, y : array
    coefficients : tuple of float
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4; those missing are 0.
    """
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = (*coefficients, *[0.0] * 12)[:12]
    r2 = x * x + y * y
    radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    seen_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * (s1 + r2 * s2)
    seen_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * (s3 + r2 * s4)
    return seen_x, seen_y


def _unfold(
    x: NDArray[np.float64], y: NDArray[np.float64], coefficients: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Invert the fisheye lens theta (1 + k1 theta^2 + ...) by Newton's method."""
    k1, k2, k3, k4 = coefficients
    seen = np.hypot(x, y)
    theta = seen.copy()
    with np.errstate(all='ignore'):
        for _ in range(ROUNDS):
            t2 = theta * theta
            slope = 1 + t2 * (3 * k1 + t2 * (5 * k2 + t2 * (7 * k3 + t2 * 9 * k4)))
            miss = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))) - seen
            theta = theta - miss / slope
            if not (np.abs(miss) > 1e-9).any():
                break
        # Beyond 90 degrees there is no ray with z = 1.
        lost = ~((np.abs(miss) < 1e-6) & (theta >= 0) & (theta < np.pi / 2))
        scale = np.where(seen > 0, np.tan(theta) / np.where(seen > 0, seen, 1.0), 1.0)
    scale[lost] = np.nan
    return x * scale, y * scale
