# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The browser that opens the report, where it dies or cannot start. Truth: programs that do so."""

import pytest
from reference.browser import Browser

FAKE = """
import json, pathlib, sys
print('"ready"', flush=True)
for line in sys.stdin:
    if 'die' in line and not pathlib.Path({0!r}).exists():
        pathlib.Path({0!r}).write_text('once')
        sys.exit('trapped')
    print(json.dumps(line), flush=True)
"""


def test_browser_that_dies_is_started_again_once_and_that_is_told(tmp_path):
    program = tmp_path / 'fake.py'
    program.write_text(FAKE.format(str(tmp_path / 'died')), encoding='utf-8')
    fake = Browser(tmp_path / 'log.txt', program)
    fake.do('visit', path='x')
    with pytest.warns(UserWarning, match='Chromium died .*trapped'):
        assert 'die' in fake.js('die')
    (tmp_path / 'died').unlink()
    with pytest.raises(AssertionError, match='died a second time'):
        fake.js('die')
    fake.close()


def test_browser_that_cannot_start_skips_with_its_reason(tmp_path):
    program = tmp_path / 'broken.py'
    program.write_text(
        'raise ImportError("libnss3.so: cannot open shared object file")', encoding='utf-8')
    with pytest.raises(pytest.skip.Exception, match='libnss3'):
        Browser(tmp_path / 'log.txt', program)
