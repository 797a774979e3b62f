# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Values out of a message of any origin, each doubt about them told in a sentence."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ros_rops.core.errors import InputError


def attribute(message: Any, name: str, kind: str) -> Any:
    """
    Return an attribute of a message.

    Raises
    ------
    InputError
        If it has none of that name: then it is no `kind` (say 'PointCloud2').
    """
    try:
        return getattr(message, name)
    except AttributeError:
        raise InputError(f'message has no attribute {name!r}: no {kind}') from None


def whole(owner: Any, name: str, kind: str) -> int:
    """
    Return an attribute that is a whole number of 32 bits.

    Raises
    ------
    InputError
        If it is missing or none.
    """
    value = attribute(owner, name, kind)
    try:
        number = int(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f'{kind}: {name} is {value!r}, no whole number') from None
    if not 0 <= number < 2**32:
        raise InputError(f'{kind}: {name} is {number}')
    return number


def octets(message: Any, kind: str) -> memoryview:
    """
    Return the attribute `data` of a message as bytes, without a copy where it is a buffer.

    Raises
    ------
    InputError
        If it is missing, or no buffer and no sequence of bytes.
    """
    data = attribute(message, 'data', kind)
    if isinstance(data, np.ndarray):
        data = np.ascontiguousarray(data)
    try:
        view = memoryview(data)
    except TypeError:
        view = memoryview(_listed(data, kind))
    try:
        return view.cast('B')
    except (TypeError, ValueError):
        raise InputError(f'{kind}: data is no contiguous run of bytes') from None


def _listed(data: Any, kind: str) -> bytes:
    # bytes(n) of a number would be n zeros.
    if isinstance(data, Sequence) and not isinstance(data, str):
        try:
            return bytes(data)
        except (TypeError, ValueError):
            pass
    raise InputError(f'{kind}: data is no sequence of bytes')
