# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Other programs on the same data in the same run, each in a process of its own."""
