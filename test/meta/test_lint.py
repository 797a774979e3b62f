# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""ROS's own linters, with their own settings. Truth: ament_lint of Jazzy."""

from meta.tree import files, name, python_files, ROOT
import pytest

CODE = ['ros_rops', 'msg_adapters', 'test', 'launch', '.ci', 'setup.py']
HEADER = '# Copyright 2026 The ros_rops authors\n# SPDX-License-Identifier: Apache-2.0\n'


def _paths() -> list[str]:
    return [path for path in CODE if (ROOT / path).exists()]


@pytest.mark.filterwarnings('ignore')
def test_flake8(monkeypatch, capfd):
    main = pytest.importorskip('ament_flake8.main', reason='no ament_flake8 here')
    monkeypatch.chdir(ROOT)
    code, _ = main.main_with_errors(_paths())
    assert code == 0, capfd.readouterr().out


@pytest.mark.filterwarnings('ignore')
def test_pep257(monkeypatch, capfd):
    main = pytest.importorskip('ament_pep257.main', reason='no ament_pep257 here')
    monkeypatch.chdir(ROOT)
    # Rules of Google's sections, which numpydoc, whose sections we use, turns off: a blank line
    # after the last one, every argument described.
    code = main.main([*_paths(), '--add-ignore', 'D413', 'D417'])
    output = capfd.readouterr()
    faults = [
        line for line in (output.out + output.err).splitlines()
        if not line.startswith('checking') and 'Checking file' not in line]
    assert code == 0, '\n'.join(faults)


def test_copyright():
    code = python_files('ros_rops', 'msg_adapters', 'test', 'launch', '.ci')
    for path in [*code, ROOT / 'setup.py']:
        assert path.read_text(encoding='utf-8').startswith(HEADER), name(path)
    for path in files('.cpp', '.hpp'):
        expected = HEADER.replace('# ', '// ')
        assert path.read_text(encoding='utf-8').startswith(expected), name(path)


def test_licence_is_the_whole_apache_2():
    text = (ROOT / 'LICENSE').read_text(encoding='utf-8')
    assert 'Version 2.0, January 2004' in text and 'END OF TERMS AND CONDITIONS' in text
