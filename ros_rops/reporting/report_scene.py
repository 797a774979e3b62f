# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the report's 3D view gets of each object, thinned so that the whole fits its limit."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from ros_rops.core.types import Floats
from ros_rops.reporting.report_files import Document, get, items_of, RunFiles
from ros_rops.reporting.report_html import figure, percent
from ros_rops.reporting.report_layers import (
    FACE, FILES, Layer, Layers, read_layers, thinned, with_normals, with_residuals, with_views)
from ros_rops.reporting.report_pack import packed
from ros_rops.reporting.report_thin import spacing
from ros_rops.reporting.residual_colours import reach_of

MOST_OF_LIMIT = 0.45
"""Of the report, for an object: more shows no more, and one object alone stays small to mail."""
IN_BASE64 = 4 / 3
CARRIED_OVER = 2
"""Bytes more a point, of what another layer lends it: its view, its residual or its normal."""
FACES_EACH = 2.1
"""Triangles a vertex of a surface has, after clustering too."""
ABOVE = 0.1
"""Radii that the arrow ends above the surface."""
REACH = 3.0
"""Spacings within which residuals are carried over."""


def scenes(files: RunFiles, budget: int, limit: int) -> Iterator[dict[str, Any]]:
    """
    Yield what the 3D view draws, object by object.

    Parameters
    ----------
    files : RunFiles
    budget : int
        Characters that all of it may take.
    limit : int
        Characters of the whole report.
    """
    objects = files.poses['objects']
    most = MOST_OF_LIMIT * limit
    shares = shared([min(_size(files, int(item['id'])), most) for item in objects], budget)
    for item, share in zip(objects, shares, strict=True):
        yield _scene(files, item, share)


def shared(needs: Sequence[float], total: float) -> list[float]:
    """Share a total so that the small get what they need, and the others equally much."""
    shares = [0.0] * len(needs)
    left = float(total)
    for count, k in enumerate(sorted(range(len(needs)), key=lambda k: needs[k])):
        shares[k] = min(float(needs[k]), left / (len(needs) - count))
        left -= shares[k]
    return shares


def _size(files: RunFiles, object_id: int) -> float:
    """Return about how many characters all of an object would take: as many as its files."""
    paths = (files.folder / pattern.format(object_id) for pattern in FILES.values())
    return float(sum(path.stat().st_size for path in paths if path.exists()))


def no_scene(files: RunFiles, item: Document) -> dict[str, Any]:
    """Return the scene of an object of which nothing is drawn."""
    numbers = [files.numbers[str(view['name'])] for view in item['views']
               if str(view['name']) in files.numbers]
    return {'id': int(item['id']), 'views': numbers, 'missing': {}, 'layers': {}}


def _scene(files: RunFiles, item: Document, share: float) -> dict[str, Any]:
    object_id = int(item['id'])
    layers = read_layers(files.folder, object_id)
    scene = no_scene(files, item) | {'missing': layers.missing}
    numbers = scene['views']
    if not layers.found:
        return scene
    first = numbers[0] if numbers else -1
    scene['flip'] = _seen_along_z(list(layers.found.values()), first)
    shown = _carried(_thin(layers, share))
    origin, edge = _box(shown.values())
    middle, radius = _ball(next(iter(shown.values())).points)
    place = {number: k for k, number in enumerate(numbers)}
    measured = layers.found.get('residuals')
    quality = files.quality_of(object_id)
    return scene | {
        'origin': origin.tolist(), 'edge': edge, 'centre': middle.tolist(), 'radius': radius,
        'arrow': _arrow(quality, next(iter(shown.values())).points, middle, radius),
        'turn': turned(get(quality, 'coverage', 'turntable')),
        'reach': 1.0 if measured is None or measured.residuals is None
        else reach_of(measured.residuals, measured.states),
        'layers': {name: packed(layer, origin, edge, place) for name, layer in shown.items()}}


def _thin(layers: Layers, share: float) -> dict[str, Layer]:
    each = {name: _bytes_each(layer) for name, layer in layers.found.items()}
    needs = [each[name] * len(layer.points) for name, layer in layers.found.items()]
    parts = shared(needs, share / IN_BASE64)
    return {
        name: thinned(layer, max(int(part / each[name]), 1))
        for (name, layer), part in zip(layers.found.items(), parts, strict=True)}


def _bytes_each(layer: Layer) -> float:
    """Return how many bytes a point takes, its share of the faces included."""
    own = layer.bytes_each + CARRIED_OVER
    return own if layer.faces is None else max(own, own + FACE * (
        FACES_EACH - len(layer.faces) / max(len(layer.points), 1)))


def _carried(shown: dict[str, Layer]) -> dict[str, Layer]:
    """Let the layers lend each other what can be coloured by."""
    cloud, measured = shown.get('cloud'), shown.get('residuals')
    viewed = cloud if cloud is not None and cloud.views is not None else measured
    result = dict(shown)
    if 'surface' in shown and viewed is not None:
        result['surface'] = with_views(shown['surface'], viewed)
    if measured is not None and measured.normals is None and cloud is not None:
        result['residuals'] = with_normals(measured, cloud)
    if measured is not None:
        reach = REACH * spacing(measured.points)
        for name in {'surface', 'cloud'} & set(shown):
            own = REACH * spacing(shown[name].points)
            result[name] = with_residuals(result[name], measured, max(reach, own))
    return result


def _box(layers: Any) -> tuple[Floats, float]:
    """Return the lowest corner and the longest edge of the box around all."""
    layers = list(layers)
    low = np.min([layer.points.min(axis=0) for layer in layers], axis=0)
    high = np.max([layer.points.max(axis=0) for layer in layers], axis=0)
    return low, float((high - low).max()) or 1.0


def _ball(points: Floats) -> tuple[Floats, float]:
    """Return middle and radius of what nearly all points lie in: a few may be far away."""
    low, high = np.quantile(points, (0.002, 0.998), axis=0)
    middle = (low + high) / 2
    radius = float(np.quantile(np.linalg.norm(points - middle, axis=1), 0.998))
    return middle, radius or 1.0


def _seen_along_z(layers: Sequence[Layer], first: int) -> bool:
    """Tell whether the view that the frame is of was taken along +z, as a camera's image is."""
    for layer in layers:
        if layer.normals is not None and layer.views is not None:
            own = layer.normals[layer.views == first, 2]
            if np.isfinite(own).any():
                return bool(np.nanmean(own) < 0)
    return False


def _arrow(
    quality: Document, points: Floats, middle: Floats, radius: float
) -> dict[str, Any] | None:
    """
    Return where to look from next, and how much that would show.

    The arrow ends at `tip` radii from the middle: a little above the object there.
    """
    for item in items_of(quality, 'coverage', 'directions'):
        direction = unit_vector(item.get('direction'))
        if direction is None:
            continue
        gain = number_of(item.get('gain_share'))
        far = float(np.quantile((points - middle) @ np.array(direction), 0.998)) / radius
        return {
            'direction': direction, 'tip': min(max(far, 0.0), 1.0) + ABOVE,
            'said': '' if gain is None else percent(gain)}
    return None


def turned(turntable: Any) -> str:
    """Return how to turn the turntable next, and what that shows; empty where it is not known."""
    angle = number_of(get(turntable, 'angle_deg'))
    if angle is None:
        return ''
    way = 'on' if angle >= 0 else 'back'
    return (f'turn it {way} by {figure(abs(angle))}\xb0 from the last view: shows '
            f'{percent(get(turntable, "gain_share"))} of the unseen')


def unit_vector(value: Any) -> list[float] | None:
    """Return three numbers as a unit vector; None if they are none."""
    try:
        vector = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return None
    size = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    return (vector / size).tolist() if np.isfinite(size) and size > 0 else None


def number_of(value: Any) -> float | None:
    """Return a finite number as a float, anything else as None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if np.isfinite(value) else None


def loops_of(quality: Document) -> Mapping[str, Any]:
    """Return what is known of the loops of an object; empty if there are none."""
    found = get(quality, 'loops')
    return found if isinstance(found, Mapping) else {}
