# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""ROS in tests: this machine only, a domain of the run's own, message fields checked."""

import os

# Before rclpy is imported. Linux keeps the ports of domains 0 to 101 free of ephemeral ones.
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 101)
os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
