# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The CameraInfo of a camera without distortion, for images that were undistorted already."""

from dataclasses import replace

import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.recordings.topics import INFO


def rectified_info(data: bytes) -> bytes:
    """
    Return a CameraInfo in CDR that says of the image as it is what the given one says by P.

    By ROS's custom only a topic's name (`image_rect...`) tells that an image is undistorted, its
    CameraInfo still has the lens. Under another name the lens would be taken out twice.

    Raises
    ------
    InputError
        If it cannot be decoded.
    """
    from rosbags.typesys import get_typestore, Stores

    store = get_typestore(Stores.ROS2_JAZZY)
    try:
        info = store.deserialize_cdr(data, INFO)
    except Exception as error:  # a message that is cut short raises what it likes
        raise InputError(f'CameraInfo: cannot be decoded ({error})') from None
    k = info.p.reshape(3, 4)[:, :3].reshape(-1) if info.p[0] else info.k
    if not np.any(info.d) and np.array_equal(k, info.k):
        return data
    plain = replace(info, d=np.zeros_like(info.d), k=k.copy())
    return bytes(store.serialize_cdr(plain, INFO))
