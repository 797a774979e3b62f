# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever yields range views: files, dataset folders, recordings, synthetic captures."""

from ros_rops.recordings.dataset import Dataset, read_dataset
from ros_rops.recordings.poses import Poses, read_conf, read_poses
from ros_rops.recordings.reader import BadView, NotedView, read_mesh, read_view, read_view_noted
from ros_rops.recordings.sources import find_views, Recording, ViewFile, ViewSource
from ros_rops.recordings.units import convert

__all__ = [
    'BadView', 'convert', 'Dataset', 'find_views', 'NotedView', 'Poses', 'read_conf',
    'read_dataset', 'read_mesh', 'read_poses', 'read_view', 'read_view_noted', 'Recording',
    'ViewFile', 'ViewSource',
]
