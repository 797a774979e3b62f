# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From the registered views of an object to its model, and how far that may be trusted."""
