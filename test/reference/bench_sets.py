# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Small data sets with exact poses, and engines whose answers are known, for the bench's tests."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
from ros_rops.bench.contest import Answer, Contestant
from ros_rops.bench.truth import ReferenceSet, units_factor
from ros_rops.core.types import RangeView, Status
from scipy.spatial.transform import Rotation


def random_pose(rng, scale=10.0):
    result = np.eye(4)
    result[:3, :3] = Rotation.random(rng=rng).as_matrix()
    result[:3, 3] = rng.normal(size=3) * scale
    return result


def turned(T, deg, about=(0, 0, 0)):
    """Turn a view by `deg` about a point of its own frame before `T`."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec([0, np.radians(deg), 0]).as_matrix()
    turn[:3, 3] = np.asarray(about) - turn[:3, :3] @ about
    return T @ turn


def strip_set(name='set', units='m', starts=(0, 2, 5, 30), seed=0):
    """Return strips of 10 x 10 points of one plane, each in its own frame, dres 1.1."""
    rng = np.random.default_rng(seed)
    views, poses = {}, {}
    for start in starts:
        world = np.array([[x, y, 0.0] for x in range(start, start + 10) for y in range(10)])
        T = random_pose(rng)
        view = f'view{start:02d}'
        views[view] = RangeView(view, (world - T[:3, 3]) @ T[:3, :3], units=units)
        poses[view] = T
    return ReferenceSet(name, units, 'exact', views, poses, 1.1)


@dataclass(frozen=True)
class Script:
    """An engine that answers from a table: errors in degrees, or None where it refuses."""

    dataset: ReferenceSet
    answers: dict

    def register(self, source, target):
        deg = self.answers[source.name, target.name]
        if deg is None:
            return Answer(Status.REFUSED, None, 'told to refuse')
        T = self.dataset.reference(source.name, target.name)
        T = np.eye(4) if T is None else T
        return Answer(Status.PLACED, turned(T, deg, source.points.mean(axis=0)), '', {'score': 1})

    def contestant(self):
        return Contestant('script', lambda view: view, self.register)


@dataclass
class Oracle:
    """A session that places every view where its job's truth says, in the job's units."""

    job: object
    merge: bool = False
    added: list = field(default_factory=list)
    objects: tuple = ()
    mesh_resolution: float = 1.0
    attempts: int = 12

    def add(self, view):
        self.added.append(view.name)

    def finish(self):
        frame = random_pose(np.random.default_rng(2))
        shapes = {}
        for name in self.added:
            known = self.job.known[name]
            T = known.T_world_view.copy()
            T[:3, 3] *= units_factor(known.units, self.job.units)
            label = 0 if self.merge else known.label
            view = SimpleNamespace(name=name, T_object_view=frame @ T)
            shapes.setdefault(label, []).append(view)
        self.objects = tuple(
            SimpleNamespace(id=k, views=views) for k, views in enumerate(shapes.values()))
