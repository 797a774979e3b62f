# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What several tests of the live station need."""

import threading

import pytest
from reference.live import Heard
from ros_rops.pipeline.session import Session


@pytest.fixture
def heard():
    return Heard()


@pytest.fixture
def gate(monkeypatch):
    """Hold the session's work until it is set."""
    opened, add = threading.Event(), Session.add

    def held(self, view):
        # The warm-up has views of these names.
        assert view.name in '01' or opened.wait(60)
        return add(self, view)

    monkeypatch.setattr(Session, 'add', held)
    yield opened
    opened.set()
