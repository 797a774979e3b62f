# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""All rival descriptors (Guo et al. 2014, V-A2, and SHOT)."""

from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.rivals.fpfh import fpfh
from ros_rops.bench.rivals.lsp import lsp
from ros_rops.bench.rivals.pcl_descriptors import shot, spin_image, usc
from ros_rops.bench.rivals.thrift import thrift


def rival_descriptors(radius_mr: float) -> tuple[Descriptor, ...]:
    """Return the rivals in the order of the paper's table, on supports of one radius."""
    return tuple(
        make(radius_mr) for make in (spin_image, lsp, thrift, usc, fpfh, shot))
