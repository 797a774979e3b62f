# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The views of a station in RViz and Foxglove.

Truth: README's table of topics and services, which test/ros/test_readme.py compares with a node.
"""

import json
import re

from meta.tree import ROOT
import yaml

README = (ROOT / 'README.md').read_text(encoding='utf-8')
ROW = re.compile(r'^\| out \| `(?P<topic>\S+)` \| `(?P<kind>\S+)` \| (?P<qos>\w+)', re.MULTILINE)
OUT = {'/' + row['topic'].lstrip('/'): row for row in ROW.finditer(README)}
SERVICES = set(re.findall(r'^\| `~/(\w+)` \|', README, re.MULTILINE))
KINDS = {'PointCloud2': 'sensor_msgs/msg/PointCloud2',
         'MarkerArray': 'visualization_msgs/msg/MarkerArray'}


def test_rviz_shows_topics_of_the_node_with_the_qos_that_they_have():
    text = (ROOT / 'rviz' / 'station.rviz').read_text(encoding='utf-8')
    displays = yaml.safe_load(text)['Visualization Manager']['Displays']
    shown = [display for display in displays if 'Topic' in display]
    for display in shown:
        topic = display['Topic']
        row = OUT[topic['Value']]
        assert KINDS[display['Class'].rpartition('/')[2]] == row['kind']
        assert (topic['Durability Policy'] == 'Transient Local') == (row['qos'] == 'latched')
        assert topic['Reliability Policy'] == 'Reliable'
        assert display['Enabled'] == display['Value']
    assert {display['Topic']['Value'] for display in shown} == {'/assembled', '/markers'}
    # In a namespace the launch file remaps each of them.
    launch = (ROOT / 'launch' / 'station.launch.py').read_text(encoding='utf-8')
    assert "SHOWN = ('assembled', 'markers')" in launch


def _panels(node) -> list[str]:
    """Return the panels of a layout, which is a tree of splits."""
    if isinstance(node, str):
        return [node]
    assert node['direction'] in ('row', 'column') and 0 < node['splitPercentage'] < 100
    return _panels(node['first']) + _panels(node['second'])


def test_foxglove_shows_and_calls_what_the_node_has():
    layout = json.loads((ROOT / 'foxglove' / 'station.json').read_text(encoding='utf-8'))
    panels = layout['configById']
    assert sorted(_panels(layout['layout'])) == sorted(panels)
    topics, services = set(), set()
    for panel in panels.values():
        topics |= set(panel.get('topics', ())) | {
            panel[key] for key in ('topicToRender', 'topicPath') if key in panel}
        if 'serviceName' in panel:
            services.add(panel['serviceName'])
            assert json.loads(panel['requestPayload']) in ({}, {'data': True}, {'data': False})
    assert topics <= set(OUT)
    assert services == {f'/rops_registration/{name}' for name in SERVICES}
