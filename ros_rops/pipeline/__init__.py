# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The incremental state: sessions, their parameters, timings and trace."""
