# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The station's node, `rops_registration`, as a command: live views in, models out."""

from collections.abc import Sequence

from ros_rops.core.node_config import describe_node
from ros_rops.nodes.signals import hold_signals
from ros_rops.nodes.usage import asked_for_help, say_usage

PURPOSE = 'the station: views from topics in, the poses and models of objects out.'


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the exit code."""
    if asked_for_help(args):
        say_usage(
            'registration_node', PURPOSE, describe_node(),
            '  and those of the engine: selection.*, segmentation.*, prior.*, ..., as in '
            'config/default.yaml')
        return 0
    hold_signals()
    # rclpy takes a while to import; a Ctrl-C meanwhile waits for its turn.
    from ros_rops.nodes.process import run_node
    from ros_rops.nodes.registration import RegistrationNode

    return run_node(RegistrationNode, args)


if __name__ == '__main__':
    raise SystemExit(main())
