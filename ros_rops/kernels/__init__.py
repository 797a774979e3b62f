# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The few loops that must be fast: C++17 sources and their typed Python faces."""
