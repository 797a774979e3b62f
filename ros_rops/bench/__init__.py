# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Cases, measurements and comparison with peers; nothing of the engine imports this room."""
