# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""README's tables of topics and services. Truth: the graph of a running node."""

import re

from meta.tree import ROOT
import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from rclpy.qos import DurabilityPolicy  # noqa: E402, I100
from ros.harness import Client, demo_clouds, NODE, station, wait_for  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402

SECTION = re.compile(r'<!-- interface: .*?<!-- end of interface -->', re.DOTALL)
NAME = NODE.strip('/')
# What every lifecycle node has.
OF_ROS = ('/rosout', '/parameter_events', '/transition_event', '/clock')
KIND = {'cloud': ('depth/', 'color/'), 'depth': ('views', 'view_facts')}


def _rows(*starts: str) -> list[list[str]]:
    """Return the cells of the rows whose first cell is one of `starts`."""
    text = SECTION.search((ROOT / 'README.md').read_text(encoding='utf-8')).group()
    rows = [[cell.strip().strip('`') for cell in line.strip('|').split('|')]
            for line in text.splitlines() if line.startswith('|')]
    return [row for row in rows if row[0].startswith(starts)]


def _topics(direction: str, kind: str, namespace: str = '') -> dict[str, str]:
    """Return the types of README's topics by whole name, but for those of other kinds."""
    return {
        topic if topic.startswith('/') else f'{namespace}/{topic}': message
        for _, topic, message, *_ in _rows(direction) if not topic.startswith(KIND[kind])}


def _found(pairs: list) -> dict[str, str]:
    return {name: kinds[0] for name, kinds in pairs if not name.endswith(OF_ROS)}


def _publishers(client: Client) -> dict[str, str]:
    return _found(client.node.get_publisher_names_and_types_by_node(NAME, '/'))


def _subscriptions(client: Client, namespace: str = '/') -> dict[str, str]:
    return _found(client.node.get_subscriber_names_and_types_by_node(NAME, namespace))


@pytest.fixture(scope='module')
def client(tmp_path_factory):
    """Return a client of a node that has an object."""
    pytest.importorskip('tf2_msgs', reason='no tf2_msgs here')
    with station(tmp_path_factory.mktemp('runs')) as (_, client):
        views = client.publisher(PointCloud2, 'views')
        for cloud in demo_clouds(5):
            views.publish(cloud)
        wait_for(
            lambda: '/objects/object_0/assembled' in _publishers(client), 'a first object')
        yield client


def test_what_it_publishes(client):
    # A second object is as the first.
    found = {k: v for k, v in _publishers(client).items() if '/object_1/' not in k}
    assert found == _topics('out', 'cloud')


def test_what_is_latched(client):
    for _, topic, _, qos, _ in _rows('out'):
        name = topic if topic.startswith('/') else f'/{topic}'
        latched = {
            one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            for one in client.node.get_publishers_info_by_topic(name) if one.node_name == NAME}
        assert latched == {qos == 'latched'}, topic


def test_what_it_listens_to(client):
    assert _subscriptions(client) == _topics('in', 'cloud')


def test_what_it_listens_to_with_a_depth_camera(tmp_path):
    with station(tmp_path, {'input.kind': 'depth'}, remap={'__ns': '/other'},
                 node=f'/other{NODE}') as (_, client):
        wait_for(lambda: _subscriptions(client, '/other') == _topics('in', 'depth', '/other'),
                 'its subscriptions')


def test_its_services(client):
    told = {f'{NODE}/{name[2:]}': kind for name, kind, _ in _rows('~/')}
    found = _found(client.node.get_service_names_and_types_by_node(NAME, '/'))
    assert told == {name: kind for name, kind in found.items() if kind.startswith('std_srvs/')}
