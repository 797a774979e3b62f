# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The shapes of a session: single views, and objects of several."""

from collections.abc import Mapping

from ros_rops.core.config import Config
from ros_rops.core.shape_growing import regrow, Shape
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats

# An object that holds this part of the other views is what is captured, and no other.
ONLY_SHARE = 0.5


class Shapes:
    """
    Shapes by key; a key is never used again.

    Parameters
    ----------
    config : Config
    threads : int

    Attributes
    ----------
    surfaces : dict of str to Surface
        Of all views, by name.
    object_ids : dict of int to int
        Of the shapes of several views, by key.
    outdated : set of int
        Keys of shapes whose surface is not yet that of their poses.
    """

    def __init__(self, config: Config, threads: int) -> None:
        self.surfaces: dict[str, Surface] = {}
        self.object_ids: dict[int, int] = {}
        self.outdated: set[int] = set()
        self._config = config
        self._threads = threads
        self._shapes: dict[int, Shape] = {}
        self._next_key = 0
        self._next_object = 0

    def __len__(self) -> int:
        """Return the number of shapes."""
        return len(self._shapes)

    @property
    def keys(self) -> list[int]:
        """Keys of all shapes, rising."""
        return sorted(self._shapes)

    def of(self, key: int) -> Shape:
        """Return a shape whose surface is that of its present poses."""
        if key in self.outdated:
            self._shapes[key] = self.regrown(self._shapes[key].members)
            self.outdated.discard(key)
        return self._shapes[key]

    def size(self, key: int) -> int:
        """Return the number of views of a shape."""
        return self._shapes[key].size

    def members(self, key: int) -> Mapping[str, Floats]:
        """Return the present poses of a shape's views, by name."""
        return self._shapes[key].members

    def regrown(self, poses: Mapping[str, Floats]) -> Shape:
        """Grow a shape anew from the views in `poses`."""
        return regrow(self.surfaces, poses, self._config, threads=self._threads)

    def insert(self, shape: Shape, object_id: int | None = None) -> int:
        """Add a shape, as the object if one is given; return its key."""
        key = self._next_key
        self._next_key += 1
        self._shapes[key] = shape
        if object_id is not None:
            self.object_ids[key] = object_id
        return key

    def new_object(self) -> int:
        """Return a number that no object had yet."""
        self._next_object += 1
        return self._next_object - 1

    def move(self, object_id: int, poses: Mapping[str, Floats]) -> None:
        """Give the views of an object better poses; its surface follows when it is needed."""
        key = self.key_of_object(object_id)
        self._shapes[key] = Shape(self._shapes[key].surface, dict(poses))
        self.outdated.add(key)

    def forget(self, key: int) -> None:
        """Drop a shape that is no more."""
        del self._shapes[key]
        self.outdated.discard(key)
        self.object_ids.pop(key, None)

    def objects(self) -> dict[int, Shape]:
        """Shapes of several views by object id."""
        return {number: self._shapes[key] for key, number in self.object_ids.items()}

    @property
    def placed_share(self) -> float:
        """Share of the views that belong to an object; 1 without views."""
        placed = sum(self.size(key) for key in self.object_ids)
        return placed / len(self.surfaces) if self.surfaces else 1.0

    def is_expected(self, small: int, large: int) -> bool:
        """Tell whether a shape is a view that can but belong to another, as far as is known."""
        others = len(self.surfaces) - self.size(small)
        return (
            self.size(small) == 1 and len(self.object_ids) <= 1
            and self.size(large) >= ONLY_SHARE * others)

    def holds(self, name: str) -> bool:
        """Whether a view is in one of the shapes."""
        return any(name in shape.members for shape in self._shapes.values())

    def key_of(self, name: str) -> int:
        """Return the key of the shape that a view is in."""
        return next(key for key, shape in self._shapes.items() if name in shape.members)

    def key_of_object(self, object_id: int) -> int:
        """Return the key of an object."""
        return next(key for key, number in self.object_ids.items() if number == object_id)
