# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The paper as plain functions on arrays: no ROS, no files, no global state."""
