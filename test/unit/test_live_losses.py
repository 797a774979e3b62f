# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the middleware lost. Truth: the numbers that are left out of those given, counted here."""

import pytest
from ros_rops.live.losses import Losses


class Graph:
    """Who publishes the topic now."""

    def __init__(self, *publishers: bytes) -> None:
        self.publishers, self.asked = publishers, 0

    def only(self) -> bytes | None:
        self.asked += 1
        return self.publishers[0] if len(self.publishers) == 1 else None


def test_gaps_of_one_publisher_are_lost_messages():
    graph = Graph(b'a')
    losses = Losses(graph.only)
    assert [losses.take(number) for number in (7, 8, 11, 12, 20)] == [0, 0, 2, 0, 7]
    assert graph.asked == 3  # not for what follows on


@pytest.mark.parametrize('numbers', [(9, 1, 2, 3), (9, 9), (9, 10)])
def test_who_begins_anew_lost_nothing(numbers):
    losses = Losses(Graph(b'a').only)
    assert [losses.take(number) for number in numbers] == [0] * len(numbers)


def test_another_publisher_lost_nothing_and_is_counted_from_then_on():
    graph = Graph(b'a')
    losses = Losses(graph.only)
    losses.take(1)
    graph.publishers = (b'b',)
    assert [losses.take(number) for number in (30, 31, 33)] == [0, 0, 1]


def test_gaps_between_several_publishers_say_nothing_but_the_middleware_does():
    graph = Graph(b'a', b'b')
    losses = Losses(graph.only)
    assert [losses.take(number) for number in (1, 8, 2, 9)] == [0] * 4
    assert [losses.note(total) for total in (3, 3, 5)] == [3, 0, 2]
    graph.publishers = (b'a',)
    assert [losses.take(number) for number in (10, 12, 13, 16)] == [0, 0, 0, 2]


def test_what_the_middleware_counted_too_counts_once():
    losses = Losses(Graph(b'a').only)
    losses.take(1)
    assert losses.note(2) == 2
    assert losses.take(4) == 0
    assert losses.take(10) == 5
    assert losses.note(7) == 0
    assert losses.note(8) == 1


def test_a_middleware_without_numbers_is_taken_by_its_own_count():
    losses = Losses(Graph(b'a').only)
    assert [losses.take(None) for _ in range(3)] == [0, 0, 0]
    assert losses.note(4) == 4
    assert losses.take(None) == 0
