# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`--help` of the nodes, which needs no ROS. Truth: the dataclasses of the parameters."""

import pytest
from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.core.node_config import describe_node
from ros_rops.core.parameter import describe_group
from ros_rops.nodes import registration_node, replay_node


@pytest.mark.parametrize('word', ['-h', '--help'])
@pytest.mark.parametrize(('module', 'infos'), [
    (registration_node, describe_node()), (replay_node, describe_group(ReplayConfig))])
def test_help_names_every_parameter(capsys, module, infos, word):
    assert module.main([word]) == 0
    said = capsys.readouterr().out
    for info in infos:
        assert f'\n  {info.name} (' in said
        assert info.description in said
