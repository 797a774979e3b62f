# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
report.html in a real Chromium, with a real mouse. Truth: the balls of `report_folders`.

Their upper half is red, the lower green; the last of four quarters is a view that lies wrong.
"""

import shutil
import subprocess

import numpy as np
import pytest
from reference.browser import Browser
from reference.report_folders import EVIL, RADIUS, write_folder
from ros_rops.reporting.report import write_report

CHROMES = ('chromium', 'chromium-browser', 'google-chrome')
MAGENTA, ARROW = (200, 0, 200), (0, 121, 107)


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    found = Browser(tmp_path_factory.mktemp('browser') / 'log.txt')
    yield found
    found.close()


@pytest.fixture(scope='module')
def reports(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs')
    return {
        'none': write_report(write_folder(folder / 'none', 0)),
        'one': write_report(write_folder(folder / 'one', 1)),
        'twenty': write_report(write_folder(folder / 'twenty', 20, rows=20)),
        'evil': write_report(write_folder(folder / 'evil', 1, name=EVIL + '{}', rows=20)),
        'filled': write_report(write_folder(folder / 'filled', 1, filled=True, left_out=True)),
        'old': write_report(write_folder(folder / 'old', 1, models=False, rows=20))}


@pytest.fixture
def one(browser, reports):
    browser.visit(reports['one'])
    yield browser
    assert browser.do('console') == []
    assert browser.do('requests') == [reports['one'].as_uri()]


def _differ(a, b):
    return np.abs(a - b).max(axis=-1).mean() > 3.0


def _middle(browser):
    x, y, width, height = browser.place('#canvas')
    return {'x': x + width / 2, 'y': y + height / 2}


def _share(picture, colour):
    """Return how much of a picture has the hue of a colour, lit or not."""
    lit = picture / np.maximum(picture.max(axis=-1, keepdims=True), 1)
    wanted = np.array(colour) / max(colour)
    strong = picture.max(axis=-1) - picture.min(axis=-1) > 60
    return float((strong & (np.abs(lit - wanted).max(axis=-1) < 0.2)).mean())


def test_mouse_turns_zooms_moves_and_reset_undoes_it(one):
    first = one.canvas()
    for act, arguments in (
        ('drag', {'dx': 160, 'dy': 90}), ('wheel', {'delta': 360}),
        ('drag', {'dx': 90, 'dy': 40, 'button': 'right'}),
    ):
        before = one.canvas()
        one.do(act, **_middle(one), **arguments)
        assert _differ(before, one.canvas()), act
    one.click('#reset')
    assert not _differ(first, one.canvas())


def test_keys_turn_zoom_and_reset(one):
    one.js('document.querySelector("#canvas").focus()')
    first = one.canvas()
    for key in ('Left', 'Up', 'Plus', 'Minus'):
        before = one.canvas()
        for _ in range(3):
            one.do('key', name=key)
        assert _differ(before, one.canvas()), key
    one.do('key', name='0')
    assert not _differ(first, one.canvas())


def test_fingers_turn_and_pinch(one):
    at = _middle(one)
    x, y = at['x'], at['y']
    first = one.canvas()
    one.do('fingers', begin=[[x, y]], end=[[x + 120, y + 60]])
    turned = one.canvas()
    assert _differ(first, turned)
    one.do('fingers', begin=[[x - 40, y], [x + 40, y]], end=[[x - 70, y], [x + 70, y]])
    near = one.canvas()
    background = first[0, 0]
    covered = [(np.abs(picture - background).max(axis=-1) > 12).mean() for picture in (
        turned, near)]
    assert covered[1] > 1.3 * covered[0]


def test_surface_shows_its_colours_and_the_arrow(one):
    shown = one.canvas(48, 32)
    # It stands as its first view saw it, from +z: y is up.
    upper, lower = shown[11:14, 21:27].mean(axis=(0, 1)), shown[21:24, 21:27].mean(axis=(0, 1))
    assert upper[0] > 2 * upper[1] and lower[1] > 2 * lower[0]
    assert _share(one.canvas(96, 64), ARROW) > 0.0005
    one.click('#arrow')
    assert _share(one.canvas(96, 64), ARROW) == 0.0


def test_colour_buttons_change_what_is_shown(one):
    one.click('[data-layer=residuals]')
    pictures = {'residual': one.canvas()}
    for colour in ('view', 'state', 'plain'):
        one.click(f'[data-colour={colour}]')
        assert one.js(f'return document.querySelector("[data-colour={colour}]").ariaPressed') == (
            'true')
        pictures[colour] = one.canvas()
    names = list(pictures)
    for k, a in enumerate(names):
        for b in names[:k]:
            assert _differ(pictures[a], pictures[b]), (a, b)


def test_view_that_lies_wrong_stands_out_and_the_scale_has_numbers(one):
    one.click('[data-layer=residuals]')
    legend = one.js('return document.querySelector("#legend").textContent')
    assert 'residual, mm' in legend and '≤ −0.1' in legend and '≥ 0.1' in legend
    one.js('viewer.lookFrom([1, 0.2, -1])')  # the last quarter
    assert _share(one.canvas(), MAGENTA) > 0.1
    one.js('viewer.lookFrom([1, 0.2, 1])')
    assert _share(one.canvas(), MAGENTA) < 0.02
    one.click('.steps button')
    assert '≥ 0.05' in one.js('return document.querySelector("#legend").textContent')


def test_hidden_views_are_gone(one):
    one.click('#arrow')
    one.click('[data-layer=cloud]')
    assert _differ(one.canvas(), np.broadcast_to(one.canvas()[0, 0], (16, 24, 3)))
    one.click('#none')
    assert (np.abs(one.canvas()[3:] - one.canvas()[3, 0]).max(axis=-1) < 12).mean() > 0.9


def test_click_reads_a_point(one):
    one.click('[data-layer=residuals]')
    one.js('viewer.lookFrom([1, 0.2, -1])')
    one.canvas()
    one.do('drag', **_middle(one), dx=0, dy=0, steps=1)
    said = one.js('return document.querySelector("#readout").textContent')
    assert 'view_3.ply' in said and 'residual 0.5 mm' in said and 'contradicted' in said


def test_tables_sort_and_a_view_is_picked_out_everywhere(one):
    column = one.js(
        'return [...document.querySelectorAll("#object-0 th")].findIndex('
        '(th) => th.textContent.startsWith("p90"))') + 1
    for first in ('view_0.ply', 'view_3.ply'):
        one.click(f'#object-0 th:nth-child({column}) button')
        assert one.js('return document.querySelector("#object-0 td a").textContent') == first
    first = one.canvas()
    one.click('#object-0 .node[data-view="2"] circle')
    rows = one.js('return [...document.querySelectorAll("tr.picked a")].map((a) => a.textContent)')
    assert set(rows) == {'view_2.ply'} and len(rows) >= 2
    assert one.js('return document.querySelectorAll(".edge.picked").length') == 3
    assert _differ(first, one.canvas())


def test_click_reads_the_surface(one):
    one.click('#arrow')
    one.js('viewer.lookFrom([0, 1, 0.001])')  # from above: the top of the ball
    one.canvas()
    one.do('drag', **_middle(one), dx=0, dy=0, steps=1)
    said = one.js('return document.querySelector("#readout").textContent')
    at = [float(v.replace('−', '-')) for v in said.partition(' at ')[2].split(' mm')[0].split(',')]
    assert np.allclose(at, [0, 1000 * RADIUS, 0], atol=5)


def test_filled_faces_are_striped_and_told(browser, reports):
    browser.visit(reports['filled'])
    assert 'no view saw' in browser.js('return document.querySelector("#legend").textContent')
    browser.js('viewer.lookFrom([0, -0.2, 1])')
    shown = browser.canvas(480, 320)
    lilac = (shown[..., 2] > shown[..., 1] + 15) & (shown[..., 2] > shown[..., 0])
    assert lilac[190:240, 220:260].mean() > 0.9 and lilac[90:130, 220:260].mean() < 0.02
    dark = shown[190:240, 220:260].mean(axis=-1)
    assert np.ptp(dark) > 50  # two shades in turn
    at = _middle(browser)
    browser.do('drag', x=at['x'], y=at['y'] + 60, dx=0, dy=0, steps=1)
    assert 'filled' in browser.js('return document.querySelector("#readout").textContent')
    assert browser.js('return document.querySelector("#list .left").textContent') == '3 view_3.ply'
    assert browser.do('console') == []


@pytest.mark.parametrize('size', [(1280, 900), (360, 740)])
def test_arrow_and_its_label_lie_apart_within_the_picture(browser, reports, size):
    browser.visit(reports['one'], *size)
    for look in ([0, 0, 1], [0, -1, 0.1], [1, 0, 0], [-0.5, 0.3, -0.8], [0, 0.6, 0.8]):
        browser.js(f'viewer.lookFrom({look})')
        browser.canvas(2, 2)
        label, tail, tip, width, height = browser.js(
            'const t = document.querySelector("#tag"), c = viewer.canvas;'
            'return [[t.offsetLeft - t.offsetWidth / 2, t.offsetTop - t.offsetHeight / 2,'
            ' t.offsetLeft + t.offsetWidth / 2, t.offsetTop + t.offsetHeight / 2],'
            ' ...viewer.arrowEnds(), c.clientWidth, c.clientHeight]')
        assert label[0] >= 0 and label[1] >= 0 and label[2] <= width and label[3] <= height
        for share in np.linspace(0, 1, 30):
            x, y = (np.array(tail) * share + np.array(tip) * (1 - share))[:2]
            assert 0 < x < width and 0 < y < height
            assert not (label[0] < x < label[2] and label[1] < y < label[3]), look


def test_no_object(browser, reports):
    browser.visit(reports['none'])
    said = browser.js('return document.body.innerText')
    assert 'There is no object' in said and 'too few to mesh' in said
    assert browser.do('console') == []


def test_finger_scrolls_the_page_or_turns_the_object_by_how_it_begins(browser, reports):
    browser.visit(reports['one'], 360, 740)
    browser.place('#canvas')
    browser.canvas()
    at, top = _middle(browser), browser.js('return scrollY')
    first = browser.js('return viewer.turn')
    x, y = at['x'], at['y']
    browser.do('fingers', begin=[[x, y + 60]], end=[[x, y - 120]], steps=12)
    browser.do('wait', ms=300)
    assert browser.js('return scrollY') > top + 40
    assert browser.js('return viewer.turn') == first
    at, top = _middle(browser), browser.js('return scrollY')
    browser.do('fingers', begin=[[at['x'] - 60, at['y']]], end=[[at['x'] + 60, at['y'] + 40]],
               steps=12)
    assert abs(browser.js('return scrollY') - top) < 20  # the end of the first scroll
    assert np.abs(np.subtract(browser.js('return viewer.turn'), first)).max() > 0.2


def test_printed_page_holds_the_picture_with_its_scale(one):
    one.js('dispatchEvent(new Event("beforeprint"))')
    assert one.js('return document.querySelector("#printed").src.length') > 5000
    assert one.js('const p = document.querySelector("#printed"); return p.naturalWidth') in (
        0, one.js('return viewer.canvas.width'))


def test_twenty_objects_on_a_phone(browser, reports, tmp_path):
    browser.visit(reports['twenty'], 360, 740)
    assert browser.js('return document.documentElement.scrollWidth <= innerWidth')
    first = browser.canvas()
    for k in range(1, 20):
        browser.js(f'document.querySelectorAll(".tabs button")[{k}].click()')
    assert browser.js('return document.querySelectorAll("article.object:not(.away)").length') == 1
    last = browser.canvas()
    assert _differ(first, last) and _differ(last, np.broadcast_to(last[0, 0], last.shape))
    assert browser.js('return viewer.gl.isContextLost()') is False
    assert browser.do('console') == []
    assert browser.do('grab', path=str(tmp_path / 'phone.png'))


def test_names_are_no_html(browser, reports):
    browser.visit(reports['evil'], before='window.alert = () => { window.hit = true; }')
    assert browser.js('return Boolean(window.hit)') is False
    assert browser.js('return document.querySelectorAll("script").length') == 5
    names = browser.js(
        'return [...document.querySelectorAll("#list label")].map((label) => label.title)')
    assert names == [f'{EVIL}{k}' for k in range(4)]
    assert browser.do('console') == []


def test_older_run_shows_its_points(browser, reports):
    browser.visit(reports['old'])
    assert browser.js('return document.querySelector("[data-layer=surface]").disabled') is True
    assert 'quality.json is not in the run folder' in browser.js('return document.body.innerText')
    shown = browser.canvas()
    assert _differ(shown, np.broadcast_to(shown[0, 0], shown.shape))


def test_without_webgl_the_page_says_so(browser, reports):
    browser.visit(reports['one'], before='HTMLCanvasElement.prototype.getContext = () => null;')
    assert 'no WebGL2' in browser.js('return document.querySelector("#fallback").innerText')
    assert browser.js('return document.querySelector("#canvas").checkVisibility()') is False
    assert browser.do('console') == []


def test_installed_chromium_opens_it_too(reports):
    found = next(filter(None, map(shutil.which, CHROMES)), None)
    if found is None:
        pytest.skip(f'none of {", ".join(CHROMES)} is installed')
    shown = subprocess.run(
        [found, '--headless', '--no-sandbox', '--use-angle=swiftshader',
         '--enable-unsafe-swiftshader', '--virtual-time-budget=4000', '--dump-dom',
         reports['one'].as_uri()], capture_output=True, text=True, timeout=60, check=True).stdout
    assert 'data-ready="yes"' in shown and '3D view of object 0' in shown
