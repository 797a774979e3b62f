# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Write what is derived from ros_rops/core/config.py: config/default.yaml, README's table."""

from pathlib import Path

from ros_rops.core.config import Config
from ros_rops.pipeline.parameters import dump_config, parameter_table

ROOT = Path(__file__).resolve().parent.parent
BEGIN = '<!-- parameters: written by `make generate` from ros_rops/core/config.py -->\n'
END = '<!-- end of parameters -->\n'
HEADER = '# Written by `make generate` from ros_rops/core/config.py: all parameters.\n'


def default_yaml() -> str:
    """Return the text of config/default.yaml."""
    return HEADER + dump_config(Config(), comments=True)


def readme(text: str) -> str:
    """Return README's `text` with the parameter table renewed."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError('README.md: the markers of the parameter table are missing')
    return before + BEGIN + parameter_table() + END + after


if __name__ == '__main__':
    page = ROOT / 'README.md'
    page.write_text(readme(page.read_text(encoding='utf-8')), encoding='utf-8')
    (ROOT / 'config' / 'default.yaml').write_text(default_yaml(), encoding='utf-8')
