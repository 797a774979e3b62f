# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command `registration_node`: the station's node, `rops_registration`, in a process."""

from collections.abc import Sequence

from ros_rops.nodes.signals import hold_signals


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the exit code."""
    hold_signals()
    # rclpy takes a while to import; a Ctrl-C meanwhile waits for its turn.
    from ros_rops.nodes.process import run_node
    from ros_rops.nodes.registration import RegistrationNode

    return run_node(RegistrationNode, args)


if __name__ == '__main__':
    raise SystemExit(main())
