# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The live station without ROS: messages in, one thread that sorts, one that owns the session."""
