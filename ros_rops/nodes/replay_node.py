# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command `replay_node`: a recording played into the topics of a station."""

from collections.abc import Sequence

from ros_rops.nodes.signals import hold_signals


def main(args: Sequence[str] | None = None) -> int:
    """Play to the end, or until SIGINT or SIGTERM; return the exit code."""
    hold_signals()
    # rclpy takes a while to import; a Ctrl-C meanwhile waits for its turn.
    from ros_rops.nodes.replay import run_replay

    return run_replay(args)


if __name__ == '__main__':
    raise SystemExit(main())
