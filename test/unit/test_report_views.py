# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What report.html says of views: names, those left out. Truth: `report_folders`."""

import json
import re

import pytest
from reference.report_folders import write_folder
from ros_rops.reporting.report import write_report
from ros_rops.reporting.report_names import LONGEST, short_names


@pytest.mark.parametrize('how', ['names', 'reasons', 'cloud'])
def test_views_left_out_of_the_model_come_first(tmp_path, how):
    folder = write_folder(tmp_path / 'run', left_out=True)
    content = json.loads((folder / 'quality.json').read_text(encoding='utf-8'))
    one = content['objects'][0]
    if how == 'reasons':
        one['left_out'] = [{'name': 'view_3.ply', 'reason': 'it stands wrong'}]
    if how == 'cloud':
        del one['left_out']
        one['cloud']['left_out'] = 'view_3.ply'
    (folder / 'quality.json').write_text(json.dumps(content), encoding='utf-8')
    words = re.sub(r'<[^>]+>', ' ', write_report(folder).read_text(encoding='utf-8'))
    why = 'it stands wrong' if how == 'reasons' else '60% of its points are contradicted'
    assert words.index('Not placed, or left out of the model') < words.index(why)
    assert words.index(why) < words.index('too few to mesh')
    assert '1 placed but left out of the model' in words


@pytest.mark.parametrize(('names', 'first'), [
    ([f'/camera/depth/points@17000000{k:02d}033312345' for k in range(30)],
     '/camera/…000000033312345'),
    ([f'/cam{c}/depth/points@17000000{k:02d}033312345' for k in range(9) for c in (1, 2)],
     '/cam1/de…000000033312345'),
    ([f'scans_of_the_afternoon/part_{k}_of_the_set_on_the_table.ply' for k in range(3)],
     'scans_of…rt_0_of_the_set…'),
    (['a' * 40, 'a' * 41], 'a' * 40), (['bun000.ply', 'bun045.ply'], 'bun000.ply')])
def test_long_names_keep_what_tells_them_apart(names, first):
    short = short_names(tuple(names))
    assert short[0] == first and len(set(short)) == len(names)
    if len(first) <= LONGEST + 1:
        assert max(map(len, short)) <= LONGEST + 1
