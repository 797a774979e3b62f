# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The `rops` command, one file a verb."""
