# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a session says of its views and objects."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ros_rops.core.types import Floats, Status


@dataclass(frozen=True, slots=True)
class ViewReport:
    """
    The current word on a view.

    Parameters
    ----------
    name : str
    status : Status
        PLACED, PENDING (waits for views that connect it), AMBIGUOUS (fits in several ways) or
        REFUSED (cannot be registered at all).
    object_id : int or None
        The object it belongs to; None unless placed.
    reason : str
        One sentence.
    numbers : mapping of str to float
        What the word rests on.
    """

    name: str
    status: Status
    object_id: int | None
    reason: str
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PlacedView:
    """
    A view of an object.

    Parameters
    ----------
    name : str
    T_object_view : (4, 4) float64
        In the session's units.
    numbers : mapping of str to float
    """

    name: str
    T_object_view: Floats
    numbers: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ObjectModel:
    """
    An object: two or more views that are registered to each other.

    Parameters
    ----------
    id : int
        Stays while the object grows; of two objects that turn out one, the smaller.
    views : tuple of PlacedView
        In order of arrival; the frame is that of the first view of the shape.
    """

    id: int  # noqa: A003
    views: tuple[PlacedView, ...]
