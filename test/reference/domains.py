# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Domains of ROS for tests, so that no two workers of a run hear each other."""

import os

# Linux keeps the ports of domains 0 to 101 free of ephemeral ones.
DOMAINS = 101


def own_domain(further: int = 0) -> int:
    """
    Return the domain of this process, or one `further` on, apart from those of other workers.

    pytest-xdist starts its workers itself: they have a parent in common.
    """
    worker = os.environ.get('PYTEST_XDIST_WORKER', '')
    if not worker:
        return 1 + (os.getpid() + further) % DOMAINS
    number = int(worker.removeprefix('gw'))
    return 1 + (os.getppid() + 37 * number + further) % DOMAINS
