# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command `replay_node`: a recording played into the topics of a station."""

from collections.abc import Sequence

from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.core.parameter import describe_group
from ros_rops.nodes.signals import hold_signals
from ros_rops.nodes.usage import asked_for_help, say_usage

PURPOSE = 'plays a recording into the topics of a station.'


def main(args: Sequence[str] | None = None) -> int:
    """Play to the end, or until SIGINT or SIGTERM; return the exit code."""
    if asked_for_help(args):
        say_usage('replay_node', PURPOSE, describe_group(ReplayConfig))
        return 0
    hold_signals()
    # rclpy takes a while to import; a Ctrl-C meanwhile waits for its turn.
    from ros_rops.nodes.replay import run_replay

    return run_replay(args)


if __name__ == '__main__':
    raise SystemExit(main())
