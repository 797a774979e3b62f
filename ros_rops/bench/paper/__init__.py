# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The experiments of Guo et al. 2014 (section V) on our data, the paper's values beside ours."""
