# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""LZF, the compression of PCD's `binary_compressed`, every step checked against the bounds."""

from ros_rops.recordings.cloud import FormatError


def decompress(data: bytes, size: int) -> bytes:
    """
    Return the `size` bytes that `data` unpacks to.

    A control byte below 32 copies that many plus one literal bytes; otherwise its upper three bits
    plus two (7: plus the next byte) are a length and the rest and the next byte a distance back.

    Raises
    ------
    FormatError
        If the stream ends early, points before its beginning or has another size.
    """
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                if at + control + 1 > end:
                    raise IndexError
                out += data[at:at + control + 1]
                at += control + 1
            else:
                length = control >> 5
                if length == 7:
                    length += data[at]
                    at += 1
                distance = ((control & 31) << 8) + data[at] + 1
                at += 1
                _repeat(out, distance, length + 2)
            if len(out) > size:
                raise FormatError('its compressed data unpacks to more than it states')
    except IndexError:
        raise FormatError('is truncated or damaged: its compressed data breaks off') from None
    if len(out) != size:
        raise FormatError(f'its compressed data unpacks to {len(out)} bytes, not {size}')
    return bytes(out)


def _repeat(out: bytearray, distance: int, length: int) -> None:
    start = len(out) - distance
    if start < 0:
        raise FormatError('its compressed data points before its own beginning')
    piece = out[start:start + length]
    if distance < length:  # the copy overlaps itself: the last `distance` bytes repeat
        piece = (piece * (length // distance + 1))[:length]
    out += piece
