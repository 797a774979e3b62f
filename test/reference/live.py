# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A live station in this process: messages for it, and a listener that waits for its words."""

from contextlib import contextmanager
from dataclasses import replace
import threading
import time

from msg_adapters import point_cloud2
import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.node_config import NodeConfig
from ros_rops.live.station import Station
from ros_rops.recordings import cdr
from ros_rops.recordings.messages import Channel, Cut, RawMessage
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import CLOUD
from ros_rops.recordings.view_facts import FACTS_TOPIC

PATIENCE = 60.0
VIEWS = Channel('views', CLOUD, 'cdr')
STILL = {
    'selection.method': 'still', 'selection.still_frames': 2, 'selection.still_s': 0.0}
PLAIN = {'segmentation.when': 'never'}


class Heard:
    """A listener that keeps what it is told."""

    def __init__(self):
        self.words = []
        self.updates = []
        self._told = threading.Condition()

    def handled(self, handled):
        with self._told:
            self.words.append(handled)
            self._told.notify_all()

    def updated(self, update):
        with self._told:
            self.updates.append(update)
            self._told.notify_all()

    def wait(self, condition):
        """Wait until a condition holds, looked at whenever something is told."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, 'it never came'
            with self._told:
                self._told.wait(0.02)

    def wait_words(self, count):
        """Wait for so many words in all."""
        self.wait(lambda: len(self.words) >= count)

    @property
    def reports(self):
        return [handled.report for handled in self.words if handled.report is not None]


@contextmanager
def station(folder, heard, values=None, *, accept=True, lookup=None, **node):
    """Run a station below a folder; `node` has the node's parameters, '__' for the point."""
    given = {
        'output.picture': False, 'output.models': False, 'output.report': False, 'threads': 2}
    given.update({name.replace('__', '.'): value for name, value in node.items()})
    made = Station(
        Config.from_flat(values or {}), NodeConfig.from_flat(given), folder, heard, lookup=lookup)
    made.start()
    made.accept(accept)
    try:
        yield made
    finally:
        assert made.close(PATIENCE)


def cloud(points, stamp_ns, frame_id='camera_optical_frame', channel=VIEWS):
    """Return a PointCloud2 as it comes from the middleware."""
    values = point_cloud2.encode(np.asarray(points, np.float32), None, None, wide=False)
    return RawMessage(channel, stamp_ns, cdr.point_cloud2(values, stamp_ns, frame_id))


def small(number):
    """Return a cloud of few points, that no session can register and every one takes."""
    points = np.random.default_rng(number).normal((0.0, 0.0, 5.0), size=(40, 3))
    return cloud(points, 1_000_000_000 + number)


def recorded(path):
    """Yield the messages of a recording with one cloud topic, on the station's topics."""
    with open_storage(path) as storage:
        topics = [channel for channel in storage.channels() if channel.kind == CLOUD]
        assert len(topics) == 1
        for raw in storage.messages(frozenset({topics[0].topic, FACTS_TOPIC})):
            assert not isinstance(raw, Cut)
            name = FACTS_TOPIC if raw.channel.topic == FACTS_TOPIC else 'views'
            channel = replace(raw.channel, topic=name, definition='', schema_encoding='')
            yield replace(raw, channel=channel, data=bytes(raw.data))


def offer_all(made, heard, messages):
    """Offer messages, each when the one before has its word."""
    for raw in messages:
        count = len(heard.words)
        made.offer(raw)
        heard.wait_words(count + 1)


def run_with_commands(made, heard, messages):
    """Offer messages; take a view back and refine in the middle, so that their order matters."""
    for number, raw in enumerate(messages):
        offer_all(made, heard, [raw])
        if number == 5:
            made.remove_last_view()
        if number == 10:
            made.finish()


def settled(made, heard):
    """Wait until nothing waits and nothing is done; return the state."""
    def idle():
        state = made.state()
        return not (state.waiting_frames or state.waiting_views or state.doing)

    heard.wait(idle)
    return made.state()


def saved(made, heard):
    """Save, wait for it, return what it came to; not twice with the same outcome."""
    before = made.state().last_save
    assert made.save().success

    def done():
        said = made.state().last_save
        return said != before and said.startswith(('saved', 'not saved'))

    heard.wait(done)
    return made.state().last_save
