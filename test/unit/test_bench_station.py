# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of `rops bench station`. Truth: computed by hand from made-up measurements."""

import importlib.util

import pytest
from ros_rops.bench.station import Figure, run, session_figures, start_figures, stream_figures
from ros_rops.core.errors import InputError


def _by_name(figures) -> dict[str, Figure]:
    return {figure.what: figure for figure in figures}


def _session(seconds) -> dict:
    return {
        'views': [{'handled_s': s, 'assembled_s': s} for s in seconds],
        'service_s': [0.01] * 99 + [0.03], 'peak_rss_mib': 500.0, 'statuses': {'placed': 30}}


def test_start_is_the_median():
    figure, = start_figures({'start_s': [1.0, 9.0, 2.0]})
    assert (figure.value, figure.reached) == (2.0, 'must')


def test_latency_is_that_of_the_ten_views_behind_the_first_ten():
    found = _by_name(session_figures(_session([9.0] * 10 + [0.2] * 10 + [0.8] * 10)))
    assert found['arrival to assembled, views 11-20, p95'].value == pytest.approx(0.2)
    assert found['arrival to assembled, views 11-20, p95'].reached == 'aim'
    assert found['the same, all views after 10, p95'].value == pytest.approx(0.8)
    assert found['service while registering, p99'].value == pytest.approx(10.2)


@pytest.mark.parametrize('power', [0.0, 1.0])
def test_exponent_is_that_of_the_growth(power):
    seconds = [0.01 * number**power for number in range(1, 61)]
    found = _by_name(session_figures(_session(seconds)))
    assert found['exponent of time per view over number of views'].value == pytest.approx(
        power, abs=1e-9)


def test_a_view_that_changed_nothing_has_no_latency():
    session = _session([0.1] * 12)
    del session['views'][11]['assembled_s']
    found = _by_name(session_figures(session))
    assert found['arrival to assembled, views 11-20, p95'].value == pytest.approx(0.1)


def test_frames_without_a_word_are_counted():
    found = _by_name(stream_figures({
        'sent': 100, 'handled': 97, 'waits_s': [0.02] * 97, 'cpu_cores': 0.7,
        'rss_mib': [100.0, 200.0, 205.0],
        'diagnostics': {'input: longest_wait_ms': '120.0', 'input: dropped': '3'}}))
    assert found['frames without a word'].value == 3
    assert found['CPU'].reached == 'must'
    assert found['memory at the end less that after 10 s'].value == pytest.approx(5.0)
    assert found['input: longest_wait_ms'].reached == 'neither'
    assert found['input: dropped'].reached is None


def test_without_rclpy_it_says_so(monkeypatch):
    monkeypatch.setattr(importlib.util, 'find_spec', lambda name: None)
    with pytest.raises(InputError, match='rclpy'):
        run(None)
