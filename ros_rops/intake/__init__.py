# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From frames to the session: select, segment, journal, register, and a word on every frame."""
