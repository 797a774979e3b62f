# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Other descriptors, estimators and view-graph strategies behind the interfaces of ours."""
