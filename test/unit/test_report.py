# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
report.html, without a browser. Truth: the folders of `report_folders`, and what is packed.

What a browser makes of it: test/system/test_report_browser.py.
"""

from base64 import b64decode
from html.parser import HTMLParser
import json
import re
import shutil
import zlib

import numpy as np
import pytest
from reference.report_folders import ball, ERROR, EVIL, write_folder
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.pipeline.parameters import dump_config
from ros_rops.reporting.mesh_files import ply_bytes
from ros_rops.reporting.report import ASSETS, write_report
from ros_rops.reporting.report_html import figure, Lengths
from ros_rops.reporting.report_layers import Layer, read_layers, thinned, with_residuals
from ros_rops.reporting.report_pack import packed
from ros_rops.reporting.report_scene import shared
from ros_rops.reporting.report_thin import cluster_vertices, every_so_many, means, spacing
from ros_rops.reporting.residual_colours import AGAINST, ALONE, SHADES
from scipy.spatial import cKDTree

PARTS = ('metrics.json', 'trace.json', 'run.json', 'quality.json', 'config.yaml', 'object_0.ply',
         'object_0_surface.ply', 'object_0_residuals.ply')


class Loads(HTMLParser):
    """What a page refers to, and its elements."""

    def __init__(self):
        super().__init__()
        self.references, self.tags, self.open_tags = [], [], []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.references += [value for name, value in attributes
                            if name in ('src', 'href', 'srcset', 'action', 'data', 'poster')]


def _data(page: str, name: str) -> dict:
    found = re.search(f'<script type="application/json" id="{name}">(.*?)</script>', page)
    return json.loads(found.group(1))


def _words(page: str) -> str:
    return re.sub(r'<[^>]+>', ' ', re.sub(r'(?s)<(script|style)\b.*?</\1>', '', page))


def _unpacked(content: str, dtype: str, columns: int = 1, *, steps: bool = False) -> np.ndarray:
    planes = np.frombuffer(zlib.decompress(b64decode(content), wbits=-15), np.uint8)
    planes = planes.reshape(columns * np.dtype(dtype).itemsize, -1)
    values = np.ascontiguousarray(planes.T).view(dtype)
    values = np.cumsum(values, axis=0, dtype=dtype) if steps else values
    return values[:, 0] if columns == 1 else values


@pytest.fixture
def folder(tmp_path):
    return write_folder(tmp_path / 'run', 2)


def test_nothing_is_loaded_from_anywhere(folder):
    page = write_report(folder).read_text(encoding='utf-8')
    loads = Loads()
    loads.feed(page)
    assert loads.references
    assert all(one.startswith(('#', 'data:')) for one in loads.references)
    assert 'default-src &#x27;none&#x27;' in page and not re.search(r'@import|url\(', page)


def test_same_folder_same_bytes(folder):
    first = write_report(folder).read_bytes()
    assert write_report(folder).read_bytes() == first


def test_what_was_not_placed_comes_first_with_its_reason(folder):
    words = _words(write_report(folder).read_text(encoding='utf-8'))
    places = [words.index(one) for one in ('too few to mesh', 'like a plane', 'that overlap it')]
    assert places == sorted(places)
    assert places[-1] < words.index('Show')
    assert '8 of 11 views placed in 2 objects; 1 pending, 1 ambiguous, 1 refused' in words


def test_parameters_that_differ_come_first_and_the_command_is_told(folder):
    page = write_report(folder).read_text(encoding='utf-8')
    assert page.index('rops.bins') < page.index('parameters at their default') < page.index(
        'rops.radius_mr')
    assert ('rops register &#x27;my scans/ä.mcap&#x27; --out run_again --config run/config.yaml '
            '--units mm') in page


@pytest.mark.parametrize('name', PARTS)
@pytest.mark.parametrize('how', ['missing', 'empty', 'garbage', 'other'])
def test_part_that_is_missing_or_broken_is_told_in_its_place(folder, name, how):
    path = folder / name
    path.unlink()
    if how != 'missing':
        path.write_bytes({'empty': b'', 'garbage': b'\xff{]:', 'other': b'[1, 2]'}[how])
    words = _words(write_report(folder).read_text(encoding='utf-8'))
    assert name in words
    assert 'Object 1' in words


@pytest.mark.parametrize('content', [
    {}, {'objects': 3}, {'objects': [None, {'id': 0}]},
    {'objects': [{'id': 0, 'views': [{'name': 7}, 'x'], 'edges': [{}], 'loops': [], 'coverage': {
        'directions': [{'direction': 'up'}, {'direction': [0, 0, 0]}, {}]}, 'surface': 'none',
        'worst_views': 3, 'notes': 'x'}]}])
def test_quality_of_another_shape_never_fails(folder, content):
    (folder / 'quality.json').write_text(json.dumps(content), encoding='utf-8')
    assert 'Object 0' in _words(write_report(folder).read_text(encoding='utf-8'))


@pytest.mark.parametrize('content', [None, '', '{}', '{"objects": [], "views": [{}]}', '[]'])
def test_folder_without_sound_poses_is_an_error(folder, content):
    (folder / 'poses.json').unlink()
    if content is not None:
        (folder / 'poses.json').write_text(content, encoding='utf-8')
    with pytest.raises(InputError, match=re.escape('poses.json')):
        write_report(folder)
    assert not (folder / 'report.html').exists()


def test_names_cannot_become_html(tmp_path):
    page = write_report(write_folder(tmp_path / 'run', name=EVIL)).read_text(encoding='utf-8')
    assert '<script>alert' not in page and 'Hänsel' in page
    assert len(re.findall('</script>', page)) == 5
    assert _data(page, 'page-data')['objects'][0]['views'][0]['name'] == EVIL


def test_file_stays_below_its_limit_and_says_what_it_left_out(tmp_path):
    folder = write_folder(tmp_path / 'run', 2, rows=130)
    whole = write_report(folder)
    assert 'all 33' in _words(whole.read_text(encoding='utf-8'))
    assert whole.stat().st_size > 2_000_000
    config = Config.from_flat({'model.report_mb': 1})
    (folder / 'config.yaml').write_text(dump_config(config), encoding='utf-8')
    thin = write_report(folder)
    assert 700_000 < thin.stat().st_size <= 1_000_000
    assert re.search(r'of 33.800 points \(\d+%\)', _words(thin.read_text(encoding='utf-8')))


def test_geometry_unpacks_to_what_the_files_say(folder):
    scene = _data(write_report(folder).read_text(encoding='utf-8'), 'geometry-0')
    layer = scene['layers']['residuals']
    raw = _unpacked(layer['position'], '<u2', 3, steps=True)
    points = raw / 65535 * scene['edge'] + scene['origin']
    truth, _, _ = ball(bumps=3)
    assert cKDTree(truth).query(points)[0].max() < scene['edge'] / 65535
    assert len(points) == len(truth)
    steps = _unpacked(layer['residual'], '<u2')
    known = steps != 65535
    residuals = (steps[known] / 4095 - 1) * layer['limit']
    views = _unpacked(layer['view'], '<u2')
    assert np.allclose(residuals[views[known] == 3], ERROR, atol=ERROR / 4000)
    assert 0.05 < 1 - known.mean() < 0.5
    assert scene['arrow']['said'] == '8.0%' and not scene['flip']
    assert scene['turn'].startswith('turn it on by 40° from the last view')


def test_normals_survive_eight_bits():
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[0] = 0
    points = np.linspace(0, 1, 500)[:, None] * np.ones(3)  # in the order that they are packed in
    packing = packed(Layer(points, normals), np.zeros(3), 1.0, {})
    square = _unpacked(packing['normal'], 'u1', 2, steps=True)
    assert square[0].tolist() == [255, 255]
    x, y = (square[1:] / 127.0 - 1).T
    z = 1 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0)
    back = np.stack([x - np.sign(x) * fold, y - np.sign(y) * fold, z], axis=1)
    back /= np.linalg.norm(back, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip((back * normals[1:]).sum(axis=1), -1, 1))).max() < 1.0


def test_thinning_is_even():
    x, y = np.meshgrid(np.arange(200.0), np.arange(100.0))
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    kept = points[every_so_many(points, 2000)]
    counts = np.histogram2d(kept[:, 0], kept[:, 1], bins=(8, 4))[0]
    assert len(kept) == 2000 and counts.min() > 0.75 * counts.mean()
    assert len(np.unique(every_so_many(points, 10 ** 6))) == len(points)
    assert spacing(points) == 1.0


@pytest.mark.parametrize('most', [30, 300, 2000])
def test_clustered_surface_keeps_its_shape_and_sense(most):
    vertices, _, faces = ball(60)
    groups, merged, kept, cell = cluster_vertices(vertices, faces, most)
    assert np.array_equal(np.sort(groups[faces[kept]]), np.sort(merged))
    small = means(vertices, groups)
    assert 0.5 * most < len(small) <= most and cell > 0
    corners = small[merged]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards = (across * corners.mean(axis=1)).sum(axis=1) > 0
    assert outwards.mean() > 0.97
    if most == 2000:
        whole = vertices[faces]
        area = np.linalg.norm(np.cross(whole[:, 1] - whole[:, 0], whole[:, 2] - whole[:, 0]),
                              axis=1).sum()
        assert np.linalg.norm(across, axis=1).sum() == pytest.approx(area, rel=0.05)
    assert len(np.unique(merged, axis=0)) == len(merged)


def test_residuals_carried_over_are_sizes_and_stay_near():
    at = np.array([[0.0, 0, 0], [1, 0, 0], [9, 0, 0]])
    measured = Layer(at, residuals=np.array([-0.5, 0.5, np.nan], np.float32))
    found = with_residuals(Layer(np.array([[0.5, 0, 0], [9, 0, 0]])), measured, 2.0)
    assert found.residuals[0] == 0.5 and np.isnan(found.residuals[1]) and not found.signed


def test_points_that_are_not_finite_are_left_out(tmp_path):
    x = np.array([0.0, np.nan, 2.0, 3.0])
    (tmp_path / 'object_5.ply').write_bytes(ply_bytes({'x': x, 'y': x, 'z': x}))
    layer = read_layers(tmp_path, 5).found['cloud']
    assert len(layer.points) == 3 and layer.of == 4


def test_shares_give_the_small_what_they_need():
    assert shared([10.0, 100.0, 1000.0], 210.0) == [10.0, 100.0, 100.0]
    assert shared([5.0, 5.0], 100.0) == [5.0, 5.0]


def test_numbers_as_they_are_written():
    assert [figure(v) for v in (None, 3, 0.0, 0.01234, -12.3456, 1234.5, 12345, float('nan'))] == [
        '–', '3', '0', '0.0123', '−12.3', '1234', '12\u202f345', '–']
    assert Lengths('m').text(0.00025) == '0.250 mm'
    assert Lengths('unknown').text(2) == '2 units'


def test_older_folder_gives_a_report(tmp_path):
    folder = write_folder(tmp_path / 'run', 1, models=False)
    for name in ('metrics.json', 'trace.json', 'run.json', 'config.yaml'):
        (folder / name).unlink()
    words = _words(write_report(folder).read_text(encoding='utf-8'))
    assert 'The view graph is not known' in words and 'Times are not known' in words
    shutil.rmtree(folder)


def test_frames_without_views_are_listed_once(folder):
    frames = [{'name': 'blurred.ply', 'word': 'bad', 'reason': 'told above', 'views': []},
              {'name': 'dark', 'word': 'empty', 'reason': 'nothing stands there', 'views': []}]
    (folder / 'frames.json').write_text(json.dumps({'frames': frames}), encoding='utf-8')
    words = _words(write_report(folder).read_text(encoding='utf-8'))
    assert 'Frames that gave no view (1)' in words and 'nothing stands there' in words
    assert 'told above' not in words


def test_colours_of_residuals_are_those_of_the_ply(folder):
    script = (ASSETS / 'viewer.js').read_text(encoding='utf-8')
    found = dict(re.findall(r'const (SCALE|STATES) = (\[\[.*?\]\]);', script))
    assert json.loads(found['SCALE']) == SHADES.tolist()
    assert [json.loads(found['STATES'])[k] for k in (0, 2)] == [list(ALONE), list(AGAINST)]
    scene = _data(write_report(folder).read_text(encoding='utf-8'), 'geometry-0')
    assert scene['reach'] == pytest.approx(1e-4)  # of what is not contradicted: 0.2 * ERROR


def test_filled_faces_come_last_also_of_a_thinned_surface(tmp_path):
    folder = write_folder(tmp_path / 'run', filled=True)
    page = write_report(folder).read_text(encoding='utf-8')
    scene = _data(page, 'geometry-0')
    layer = scene['layers']['surface']
    heights = _unpacked(layer['position'], '<u2', 3, steps=True)[:, 1] / 65535 * scene['edge'] \
        + scene['origin'][1]
    zigzag = _unpacked(layer['faces'], '<u4').astype(np.int64).reshape(-1, 3)
    steps = (zigzag >> 1) ^ -(zigzag & 1)
    first = np.cumsum(steps[:, :1], axis=0)
    faces = np.hstack([first, first + steps[:, 1:]])
    below = heights[faces].mean(axis=1) < 0
    assert layer['filled'] == below.sum() > 100 and below[-layer['filled']:].all()
    assert 'of them filled, striped' in _words(page)
    thin = thinned(read_layers(folder, 0).found['surface'], 500)
    below = thin.points[thin.faces, 1].mean(axis=1) < 0
    assert (below == thin.filled).mean() > 0.9
