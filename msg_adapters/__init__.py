# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Messages to arrays and back, by attribute names only: no ROS import."""
