# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How time, memory and registrations grow with views and with objects."""
