# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The views of objects assembled to clouds, quickly, after every change.

The shown points of each view are chosen once and kept in the view's own frame; an update moves
them by the poses and nothing else. Every point that goes out is one that was measured.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats, Ints, RangeView
from ros_rops.live.places import metres
from ros_rops.live.thinning import spread_order
from ros_rops.live.words import Update
from ros_rops.pipeline.prepare import PreparedView
from scipy.spatial import cKDTree

Words32 = NDArray[np.float32]

GREY = 180
"""Every channel of the colour of points without one, among points that have one."""
GEOMETRY = ('x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z')
IDS = ('object_id', 'view_id')


@dataclass(frozen=True, slots=True)
class Piece:
    """
    A view in a cloud.

    Parameters
    ----------
    object_id : int
    view : str
    T_cloud_view : (4, 4) float64
        In metres.
    """

    object_id: int
    view: str
    T_cloud_view: Floats


@dataclass(frozen=True, slots=True)
class Cloud:
    """
    A cloud as it goes out: all fields are words of four bytes.

    Parameters
    ----------
    fields : tuple of str
        x, y, z (metres), normal_x, normal_y, normal_z (unit, towards the sensor that saw the
        point; zero where its view's mesh has none), rgb (packed; only if a view has colours),
        object_id, view_id (int32).
    words : (N, len(fields)) float32
        The last two columns are int32 by their bits.
    """

    fields: tuple[str, ...]
    words: Words32

    @property
    def whole(self) -> tuple[str, ...]:
        """Return the names of the fields that are int32."""
        return IDS


class Assembly:
    """
    Build clouds of the session's views.

    For one thread.

    Parameters
    ----------
    spacing_mr : float
        Thin each view to about this distance of points, in its own mesh resolutions; 0 does not.
    most_points : int
        Thin all views evenly so that together they have no more.
    """

    def __init__(self, spacing_mr: float, most_points: int) -> None:
        self._spacing, self._most = spacing_mr, most_points
        self._shown: dict[str, _Shown] = {}
        self._update = Update()
        self._share = 1.0

    def take(self, update: Update) -> None:
        """Choose the points of views that were placed, forget those of views that are gone."""
        placed = [view.name for model in update.objects for view in model.views]
        scale = metres(update.units)
        shown = {}
        for name in placed:
            view, prepared = update.views[name], update.prepared[name]
            known = self._shown.get(name)
            if known is None or known.of != (id(view), id(prepared), scale):
                known = _Shown(view, prepared, self._spacing, scale)
            shown[name] = known
        self._shown, self._update = shown, update
        self._share = self._fair_share()

    def cloud(self, pieces: Iterable[Piece]) -> Cloud:
        """Return the cloud of views of the update that was taken last."""
        listed = [(piece, self._rows(piece.view)) for piece in pieces]
        coloured = any(self._shown[piece.view].coloured for piece, _ in listed)
        fields = (*GEOMETRY, *(('rgb',) if coloured else ()), *IDS)
        words = np.empty((sum(len(rows) for _, rows in listed), len(fields)), np.float32)
        at = 0
        for piece, rows in listed:
            block = words[at:at + len(rows)]
            rotation = piece.T_cloud_view[:3, :3].T.astype(np.float32)
            np.matmul(rows[:, :3], rotation, out=block[:, :3])
            block[:, :3] += piece.T_cloud_view[:3, 3].astype(np.float32)
            np.matmul(rows[:, 3:6], rotation, out=block[:, 3:6])
            if coloured:
                block[:, 6] = rows[:, 6]
            numbers = piece.object_id, self._update.numbers[piece.view]
            block.view(np.int32)[:, -2:] = numbers
            at += len(rows)
        return Cloud(fields, words)

    def key(self, pieces: Iterable[Piece]) -> tuple[object, ...]:
        """Return what a cloud of these pieces depends on: equal keys, equal clouds."""
        return tuple(
            (piece.object_id, self._update.numbers[piece.view], piece.T_cloud_view.tobytes(),
             self._share, self._shown[piece.view].of) for piece in pieces)

    def _rows(self, name: str) -> Words32:
        shown = self._shown[name]
        return shown.rows(int(len(shown.order) * self._share))

    def _fair_share(self) -> float:
        """Return the share of each view's points that is shown; it falls in steps of a half."""
        # In steps: objects that did not change stay as they are while others grow.
        counts = [len(shown.order) for shown in self._shown.values()]
        if sum(counts) <= self._most:
            return 1.0
        steps = math.ceil(2 * math.log2(sum(counts) / self._most))
        return float(2.0 ** (-steps / 2))


class _Shown:
    """The points of a view that are shown, in its own frame, in metres, ready to be moved."""

    def __init__(
        self, view: RangeView, prepared: PreparedView, spacing_mr: float, scale: float
    ) -> None:
        self.of = (id(view), id(prepared), scale)
        self.coloured = view.colors is not None
        self.order: Ints = spread_order(view.points, spacing_mr * prepared.mesh.resolution)
        # Kept, so that their `id` is not another's.
        self._view, self._prepared, self._scale = view, prepared, scale
        self._rows: Words32 | None = None

    def rows(self, count: int) -> Words32:
        """Return x y z, normal, packed colour of the first `count` points, (count, 7)."""
        rows = self._rows
        # Many views share the room of few: what is not shown any more is not kept.
        if rows is None or not count <= len(rows) <= 2 * count:
            rows = self._build(count) if rows is None or len(rows) < count else rows[:count].copy()
            self._rows = rows
        return rows[:count]

    def _build(self, count: int) -> Words32:
        pick = self.order[:count]
        rows = np.empty((count, 7), np.float32)
        rows[:, :3] = self._view.points[pick] * self._scale
        rows[:, 3:6] = _normals(self._view, self._prepared, pick)
        rows[:, 6] = _packed(self._view, pick)
        return rows


def _normals(view: RangeView, prepared: PreparedView, pick: Ints) -> Floats:
    mesh = prepared.mesh
    if len(mesh.vertices) != len(view.points):
        # The mesh is coarser than the view (`core.sampling`).
        pick = cKDTree(mesh.vertices).query(view.points[pick], workers=1)[1]
    normals: Floats = mesh.normals[pick]
    return normals


def _packed(view: RangeView, pick: Ints) -> Words32:
    if view.colors is None:
        grey = np.uint32(GREY << 16 | GREY << 8 | GREY)
        return np.full(len(pick), grey).view(np.float32)
    red, green, blue = view.colors[pick].T.astype(np.uint32)
    packed: NDArray[np.uint32] = red << 16 | green << 8 | blue
    return packed.view(np.float32)


def pieces_of(poses: Mapping[int, Mapping[str, Floats]], object_id: int) -> list[Piece]:
    """Return the views of an object in its own frame; `poses` as `live.places.poses` has them."""
    return [Piece(object_id, name, T) for name, T in poses[object_id].items()]
