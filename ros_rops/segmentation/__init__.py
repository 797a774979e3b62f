# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From a raw sensor frame to the objects' range views: crop, table, background, stillness."""
