# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Register unordered range views into one model per object (Guo et al. 2014)."""

__version__ = '0.1.0'
