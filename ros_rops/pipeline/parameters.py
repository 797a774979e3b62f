# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Parameters in the forms that people read and write: ROS parameter files and tables.

Everything here is derived from `ros_rops.core.config`; a value is checked there and nowhere else.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
import re

from ros_rops.core.config import Config, describe
from ros_rops.core.errors import ParameterError
from ros_rops.core.node_config import describe_node, NodeConfig
from ros_rops.core.parameter import ParameterInfo, Scalar
import yaml

# What a node declares by itself, and `ros2 param dump` therefore writes.
_OF_ROS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')
_WIDTH = 99


def load_config(path: Path | str) -> Config:
    """
    Read a ROS parameter file.

    Parameters
    ----------
    path : path
        YAML as ROS takes it, and as `ros2 param dump` or `dump_config` writes it: a node's name
        (or ``/**`` for any node), under it ``ros__parameters``, under it the parameters, by
        groups or by dotted names. Values for ``/**`` come first, those of the node over them.
        What is of the node alone is checked and left out.

    Raises
    ------
    ParameterError
        If the file cannot be read or is no such file, or names an unknown parameter, or a value
        has the wrong type or is out of bounds. The text names file and parameter.
    """
    try:
        text = Path(path).read_text(encoding='utf-8')
        return configs_of(parse_parameters(text))[0]
    except OSError as error:
        raise ParameterError(f'{path}: cannot be read ({error.strerror or error})') from error
    except UnicodeDecodeError as error:
        raise ParameterError(f'{path}: is no text ({error.reason})') from error
    except ParameterError as error:
        raise ParameterError(f'{path}: {error}') from error


def configs_of(flat: Mapping[str, object]) -> tuple[Config, NodeConfig]:
    """
    Return the engine's and the node's parameters out of one parameter file's.

    Raises
    ------
    ParameterError
        For an unknown name, a wrong type or a value out of bounds.
    """
    of_node = {info.name for info in describe_node()}
    node = NodeConfig.from_flat({k: value for k, value in flat.items() if k in of_node})
    engine = Config.from_flat({k: value for k, value in flat.items() if k not in of_node})
    return engine, node


def parse_parameters(text: str) -> dict[str, object]:
    """
    Return the parameters of a ROS parameter file's text by dotted name, unchecked.

    Raises
    ------
    ParameterError
        If the text is not YAML or not a ROS parameter file.
    """
    try:
        tree = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ParameterError(f'not YAML: {" ".join(str(error).split())}') from None
    if tree is None:
        return {}
    if not isinstance(tree, dict):
        raise ParameterError(f'expected a node name and ros__parameters, got {_short(tree)}')
    nodes = sorted((name for name in tree if name != '/**'), key=str)
    if len(nodes) > 1:
        raise ParameterError(f'parameters of more than one node: {", ".join(map(str, nodes))}')
    flat: dict[str, object] = {}
    for node in [name for name in tree if name == '/**'] + nodes:
        flat.update(_of_node(str(node), tree[node]))
    return flat


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + '...'


def _of_node(node: str, section: object) -> dict[str, object]:
    if not isinstance(section, dict) or list(section) != ['ros__parameters']:
        raise ParameterError(f'{node}: expected ros__parameters under it (a ROS parameter file)')
    values = section['ros__parameters']
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise ParameterError(f'{node}: ros__parameters holds no parameters but {values!r}')
    return {
        name: value for name, value in _flatten(values)
        if name.partition('.')[0] not in _OF_ROS
    }


def _flatten(tree: Mapping[object, object], prefix: str = '') -> Iterator[tuple[str, object]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flatten(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value


def parse_assignments(assignments: Iterable[str]) -> dict[str, object]:
    """
    Return the parameters of texts such as ``rops.radius_mr=12`` by dotted name.

    Values are read as YAML reads them, so ``true``, ``3`` and ``0.5`` have their types.

    Raises
    ------
    ParameterError
        If a text is not of the form name=value.
    """
    flat: dict[str, object] = {}
    for text in assignments:
        name, sign, value = text.partition('=')
        if not sign or not name.strip():
            raise ParameterError(f'{text!r}: expected name=value')
        try:
            flat[name.strip()] = yaml.safe_load(value)
        except yaml.YAMLError:
            raise ParameterError(f'{name.strip()}: cannot read the value {value!r}') from None
    return flat


def dump_config(config: Config, comments: bool = False) -> str:
    """
    Return `config` as the text of a ROS parameter file for any node.

    With `comments`, each parameter's unit, bounds and sentence stand above it.
    """
    lines = ['/**:', '  ros__parameters:']
    values = config.to_flat()
    group = ''
    for info in describe():
        prefix, _, leaf = info.name.partition('.')
        if prefix != group:
            group = prefix
            lines.append(f'    {group}:')
        if comments:
            lines += _wrapped(_sentence(info), '      # ')
        lines.append(f'      {leaf}: {scalar_text(values[info.name])}')
    return '\n'.join(lines) + '\n'


def scalar_text(value: Scalar) -> str:
    """Return `value` as YAML that is read back with the same type and bits."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        mantissa, exponent, power = repr(value).partition('e')
        return (mantissa if '.' in mantissa else mantissa + '.0') + exponent + power
    if isinstance(value, int):
        return str(value)
    return value if _plain(value) else "'" + value.replace("'", "''") + "'"


def _plain(text: str) -> bool:
    # ROS's own reader takes y, n, nan and 1e5 for other things than text, PyYAML does not.
    word = re.fullmatch('[A-Za-z_]{2,}', text) is not None
    return word and text.lower() not in ('nan', 'inf') and yaml.safe_load(text) == text


def bounds_text(info: ParameterInfo) -> str:
    """Return what values `info` allows, in words; empty for any."""
    if info.choices:
        return ' or '.join(info.choices)
    if info.low is None and info.high is None:
        return ''
    if info.high is None:
        return f'from {info.low:g}'
    if info.low is None:
        return f'up to {info.high:g}'
    return f'{info.low:g} to {info.high:g}'


def parameter_table(infos: Iterable[ParameterInfo]) -> str:
    """Return parameters as rows of a Markdown table."""
    rows = ['| parameter | default | unit | allowed | what it does |', '|---|---|---|---|---|']
    for info in infos:
        sentence = info.description.replace('|', '\\|')
        rows.append(
            f'| `{info.name}` | {scalar_text(info.default)} | {info.unit} | {bounds_text(info)} '
            f'| {sentence} |')
    return '\n'.join(rows) + '\n'


def _sentence(info: ParameterInfo) -> str:
    allowed = ', '.join(text for text in (info.unit, bounds_text(info)) if text)
    return f'{info.description} [{allowed}]' if allowed else info.description


def _wrapped(text: str, prefix: str) -> list[str]:
    lines = [prefix.rstrip()]
    for word in text.split():
        line = f'{lines[-1]} {word}'
        if len(line) <= _WIDTH:
            lines[-1] = line
        else:
            lines.append(f'{prefix}{word}')
    return lines
