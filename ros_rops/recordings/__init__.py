# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever yields range views: files, dataset folders, recordings, synthetic captures."""
