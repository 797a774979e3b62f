# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Write what is derived from the parameters' dataclasses: config/default.yaml, README's tables."""

from functools import partial
from pathlib import Path

from ros_rops.core.config import Config, describe
from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.core.node_config import describe_node
from ros_rops.core.parameter import describe_group
from ros_rops.pipeline.parameters import dump_config, parameter_table

ROOT = Path(__file__).resolve().parent.parent
# Title of a table -> what it lists.
TABLES = {
    'parameters': describe,
    'parameters of registration_node': describe_node,
    'parameters of replay_node': partial(describe_group, ReplayConfig),
}
BEGIN = '<!-- {}: written by `make generate` from ros_rops/core/ -->\n'
END = '<!-- end of {} -->\n'
HEADER = '# Written by `make generate` from ros_rops/core/config.py: all parameters.\n'


def default_yaml() -> str:
    """Return the text of config/default.yaml."""
    return HEADER + dump_config(Config(), comments=True)


def readme(text: str) -> str:
    """Return README's `text` with the tables of parameters renewed."""
    for title, infos in TABLES.items():
        before, begin, rest = text.partition(BEGIN.format(title))
        _, end, after = rest.partition(END.format(title))
        if not begin or not end:
            raise ValueError(f'README.md: the markers of the table of {title} are missing')
        text = before + begin + parameter_table(infos()) + end + after
    return text


if __name__ == '__main__':
    page = ROOT / 'README.md'
    page.write_text(readme(page.read_text(encoding='utf-8')), encoding='utf-8')
    (ROOT / 'config' / 'default.yaml').write_text(default_yaml(), encoding='utf-8')
