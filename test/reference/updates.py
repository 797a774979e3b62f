# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""States of a session made by hand, of objects whose places are known exactly."""

from dataclasses import dataclass, field

import numpy as np
from ros_rops.core.types import RangeMesh, RangeView, SensorModel, Status
from ros_rops.live.words import Update
from ros_rops.pipeline.prepare import PreparedView
from ros_rops.pipeline.reports import ObjectModel, PlacedView, ViewReport
from scipy.spatial.transform import Rotation

COUNT = 400


def pose(rng, distance=0.5):
    """Return a rotation at random and a shift of about `distance` along z."""
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = [0.0, 0.0, distance] + 0.05 * rng.normal(size=3)
    return T


def ball(rng, count=COUNT, radius=0.1):
    """Return points on a sphere with their normals, both (N, 3)."""
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return radius * normals, normals


@dataclass
class Station:
    """
    Views of objects that stand at exact places before a sensor; `update` tells of all.

    Lengths are in `units`; the places given and kept are in metres.
    """

    units: str = 'm'
    count: int = COUNT
    colored: bool = True
    kind: str = 'pinhole'
    seed: int = 0
    epoch: int = 0
    views: dict = field(default_factory=dict)
    prepared: dict = field(default_factory=dict)
    members: dict = field(default_factory=dict)
    places: dict = field(default_factory=dict)
    waiting: dict = field(default_factory=dict)
    numbers: dict = field(default_factory=dict)

    def __post_init__(self):
        self.rng = np.random.default_rng(self.seed)

    @property
    def scale(self):
        """Return what a metre is in `units`."""
        return 1000.0 if self.units == 'mm' else 1.0

    def see(self, name, object_id=None, *, frame_id='camera', T_sensor_object=None,
            T_fixed_sensor=None, status=Status.PENDING, coarse=False):
        """Add a view of an object (None: of one that waits) that stands at a place."""
        T = pose(self.rng) if T_sensor_object is None else T_sensor_object
        points, normals = ball(self.rng, self.count)
        points = (points @ T[:3, :3].T + T[:3, 3]) * self.scale
        normals = normals @ T[:3, :3].T
        colors = self.rng.integers(0, 256, points.shape, dtype=np.uint8) if self.colored else None
        if T_fixed_sensor is not None:
            T_fixed_sensor = scaled(T_fixed_sensor, self.scale)
        view = RangeView(
            name, points, sensor=SensorModel(self.kind), colors=colors, units=self.units,
            stamp_ns=1_000_000_007 * (1 + len(self.numbers)), frame_id=frame_id,
            T_fixed_sensor=T_fixed_sensor)
        step = 3 if coarse else 1
        mesh = RangeMesh(
            points[::step], np.zeros((0, 3), np.int32), normals[::step],
            np.zeros(len(points[::step]), bool), 0.01 * self.scale)
        self.views[name], self.prepared[name] = view, PreparedView(view, mesh, None)
        self.numbers[name] = len(self.numbers)
        if object_id is None:
            self.waiting[name] = status
        else:
            self.places[name] = T
            self.members.setdefault(object_id, []).append(name)
        return view

    def take_back(self, name):
        del self.views[name], self.prepared[name]
        for members in self.members.values():
            if name in members:
                members.remove(name)

    def T_object_view(self, object_id, name):  # noqa: N802
        """Return the pose in metres: that of the first view's frame is the object's."""
        first = self.places[self.members[object_id][0]]
        return first @ np.linalg.inv(self.places[name])

    def place(self, object_id, name):
        """Return where the frame of the object stands before the sensor in a view, in metres."""
        return np.linalg.inv(self.T_object_view(object_id, name))

    def update(self, *changed):
        """Return the state; `changed` are names of views whose word is new."""
        objects = tuple(
            ObjectModel(object_id, tuple(
                PlacedView(name, scaled(self.T_object_view(object_id, name), self.scale), {})
                for name in names))
            for object_id, names in sorted(self.members.items()) if len(names) > 1)
        owner = {view.name: model.id for model in objects for view in model.views}
        reports = tuple(
            ViewReport(name, Status.PLACED, owner[name], 'fits well', {'score': 0.123456789})
            if name in owner else
            ViewReport(name, self.waiting.get(name, Status.PENDING), None, 'waits for views', {})
            for name in self.views)
        return Update(
            objects, dict(self.views), dict(self.prepared), reports,
            tuple(report for report in reports if report.name in changed), dict(self.numbers),
            list(self.views)[-1] if self.views else '', self.units, 0.01 * self.scale,
            epoch=self.epoch)


def scaled(T, factor):
    """Return a rigid transform with its lengths times `factor`."""
    result = np.array(T)
    result[:3, 3] *= factor
    return result
