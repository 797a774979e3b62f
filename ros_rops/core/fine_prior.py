# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What a station knows, as further terms of the joint step over all views of a shape.

A plane common to all views, or an axis common to all motions, is an unknown of its own beside the
views' motions: nothing hangs on how well one view shows it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.core.fine_system import Frames, skew, System
from ros_rops.core.station import Axis
from ros_rops.core.types import Floats, Ints, SupportPlane


@dataclass(frozen=True, slots=True)
class FinePrior:
    """
    What the views of a shape have in common.

    Parameters
    ----------
    planes : sequence of SupportPlane or None
        What each view shows of the supporting plane, in its own frame; all None if that is not
        to be used.
    axis : Axis or None
        First guess of the turntable's axis in the frame of the sensor.
    weight : float
        As a multiple of that of a view's matches.
    """

    planes: Sequence[SupportPlane | None]
    axis: Axis | None
    weight: float


class PriorTerms:
    """A `FinePrior` at work: keeps the present plane or axis and renews it with every step."""

    def __init__(self, prior: FinePrior, poses: Floats, frames: Frames) -> None:
        self._prior = prior
        # What turns the unknown by one unit of length, as for the views.
        self._size = float(frames.sizes.mean())
        self._seen = [k for k, plane in enumerate(prior.planes) if plane is not None]
        if prior.axis is not None:
            self._direction = np.asarray(prior.axis.direction)
            self._point = np.asarray(prior.axis.point)
        else:
            self._direction, self._point = self._mean_plane(poses, frames)

    def extend(
        self, system: System, poses: Floats, frames: Frames, components: Ints
    ) -> tuple[System, Ints]:
        """
        Add the terms, and the plane or axis as one more unknown (V + 1), to a system.

        Returns
        -------
        System
        components : (V + 1,) int32
        """
        count = len(system.weight)
        blocks = np.zeros((count + 1, count + 1, 6, 6))
        blocks[:count, :count] = system.blocks
        right = np.vstack([system.right, np.zeros(6)])
        wider = System(blocks, right, np.append(system.weight, 0.0))
        if self._prior.axis is not None:
            self._add_axis(wider, poses, frames, components)
        else:
            self._add_plane(wider, poses, frames)
        return wider, np.append(components, components[:1])

    def update(self, motion: Floats) -> None:
        """Move the plane or axis by its part (6,) of a step."""
        direction = self._direction + np.cross(motion[:3] / self._size, self._direction)
        self._direction = direction / np.linalg.norm(direction)
        self._point = self._point + motion[3:]

    def _mean_plane(self, poses: Floats, frames: Frames) -> tuple[Floats, Floats]:
        normals = np.array([self._normal(k, poses) for k in self._seen])
        feet = np.array([self._foot(k, poses, frames) for k in self._seen])
        mean = normals.mean(axis=0)
        return mean / np.linalg.norm(mean), feet.mean(axis=0)

    def _normal(self, k: int, poses: Floats) -> Floats:
        plane = self._prior.planes[k]
        normal: Floats = poses[k, :3, :3] @ np.asarray(plane.normal if plane else (0, 0, 0))
        return normal

    def _foot(self, k: int, poses: Floats, frames: Frames) -> Floats:
        """Return the point below a view's middle, on the plane as that view shows it."""
        plane, normal = self._prior.planes[k], self._normal(k, poses)
        offset = (plane.offset if plane else 0.0) + poses[k, :3, 3] @ normal
        foot: Floats = frames.middles[k] - normal * (frames.middles[k] @ normal - offset)
        return foot

    def _add_plane(self, system: System, poses: Floats, frames: Frames) -> None:
        """Each view's plane lies in the common one: its normal, and its foot's height."""
        node, up, origin = len(frames.sizes), self._direction, self._point
        for k in self._seen:
            normal, foot = self._normal(k, poses), self._foot(k, poses, frames)
            size, weight = frames.sizes[k], self._prior.weight * system.weight[k]
            tilt = np.zeros((3, 6)), np.zeros((3, 6))
            tilt[0][:, :3] = -skew(normal)
            tilt[1][:, :3] = skew(up) * size / self._size
            _add(system, weight, (normal - up) * size, {k: tilt[0], node: tilt[1]})
            height = np.zeros((1, 6)), np.zeros((1, 6))
            height[0][0, :3] = np.cross(foot - frames.middles[k], up) / size
            height[0][0, 3:] = up
            height[1][0, :3] = np.cross(up, foot - origin) / self._size
            height[1][0, 3:] = -up
            _add(system, weight, np.array([(foot - origin) @ up]), {k: height[0], node: height[1]})

    def _add_axis(
        self, system: System, poses: Floats, frames: Frames, components: Ints
    ) -> None:
        """Each view carries the axis to where the first of its component carries it."""
        node, anchors = len(frames.sizes), np.unique(components, return_index=True)[1]
        for k, anchor in enumerate(anchors[components]):
            weight = self._prior.weight * system.weight[k]
            if k != anchor:
                self._add_turn(system, weight, poses, frames, (k, int(anchor), node))
            plane = self._prior.planes[k]
            if plane is not None:  # the turntable is level: its axis is the plane's normal
                own = np.zeros((3, 6))
                sense = np.sign(self._direction @ np.asarray(plane.normal))
                own[:, :3] = -skew(self._direction) * frames.sizes[k] / self._size
                lean = self._direction - sense * np.asarray(plane.normal)
                _add(system, weight, lean * frames.sizes[k], {node: own})

    def _add_turn(
        self, system: System, weight: float, poses: Floats, frames: Frames,
        places: tuple[int, int, int],
    ) -> None:
        k, anchor, node = places
        size = frames.sizes[k]
        apart = poses[k, :3, :3] - poses[anchor, :3, :3]
        tilts, shifts = {}, {}
        for view, sign in ((k, 1.0), (anchor, -1.0)):
            turned = poses[view, :3, :3] @ self._direction
            placed = poses[view, :3, :3] @ self._point + poses[view, :3, 3]
            tilts[view], shifts[view] = np.zeros((3, 6)), np.zeros((3, 6))
            tilts[view][:, :3] = -sign * skew(turned) * size / frames.sizes[view]
            shifts[view][:, :3] = -sign * skew(placed - frames.middles[view]) / frames.sizes[view]
            shifts[view][:, 3:] = sign * np.eye(3)
        tilts[node], shifts[node] = np.zeros((3, 6)), np.zeros((3, 6))
        tilts[node][:, :3] = -apart @ skew(self._direction) * size / self._size
        shifts[node][:, 3:] = apart
        shift = apart @ self._point + poses[k, :3, 3] - poses[anchor, :3, 3]
        _add(system, weight, apart @ self._direction * size, tilts)
        _add(system, weight, shift, shifts)


def _add(system: System, weight: float, residual: Floats, slopes: dict[int, Floats]) -> None:
    """Add the square of a residual (M,) whose slopes (M, 6) by the motions are given."""
    for a, slope in slopes.items():
        system.right[a] -= weight * slope.T @ residual
        for b, other in slopes.items():
            system.blocks[a, b] += weight * slope.T @ other
    # The extra unknown is held by what the terms hold it with.
    if len(system.weight) - 1 in slopes:
        system.weight[-1] += weight
