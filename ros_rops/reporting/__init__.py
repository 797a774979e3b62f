# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a run leaves behind: the run folder, tables, explanations, pictures."""
