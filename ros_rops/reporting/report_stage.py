# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The stage of the report: one 3D view for all objects, and what it is steered by."""

from collections.abc import Sequence

from ros_rops.reporting.report_files import Document, RunFiles
from ros_rops.reporting.report_html import text
from ros_rops.reporting.report_objects import SHOWN

COLOURS = {'plain': 'plain', 'view': 'view', 'residual': 'residual', 'rgb': 'as captured',
           'state': 'agreement'}
HELP = ('Drag to turn, wheel or pinch to zoom, right button, Shift or two fingers to move; click '
        'a point to read it. On a touch screen: start sideways to turn, up or down scrolls the '
        'page. Keys: arrows turn, Shift with arrows moves, + and − zoom, 0 resets.')


def stage(files: RunFiles, objects: Sequence[Document]) -> str:
    """Return the 3D view; the page's script fills it."""
    tabs = ''.join(
        f'<button type="button" role="tab" data-object="{item["id"]}">Object {item["id"]}'
        f'<small>{len(item["views"])} views</small></button>' for item in objects)
    return f"""<div class="tabs" role="tablist" aria-label="Objects">{tabs}</div>
<div class="stage">
<div class="view3d">
<canvas id="canvas" tabindex="0" role="img" aria-label="3D view" aria-describedby="keys"></canvas>
<p class="fallback" id="fallback">No 3D view: it needs JavaScript and WebGL2. The picture further
down shows the objects from three sides.</p>
<div id="readout" class="readout" role="status" aria-live="polite"></div>
<div id="tag" class="tag" hidden></div>
<img id="printed" alt="3D view">
<div id="bar" class="scalebar" aria-hidden="true"><span></span></div>
<div class="tools">
{_button('reset', 'Reset the view', '⌂')}{_button('nearer', 'Zoom in', '+')}
{_button('farther', 'Zoom out', '−')}{_button('save', 'Save as PNG', '⤓')}
</div></div>
<div class="panel">
<fieldset><legend>Show</legend><div class="choice">{_choices('layer', SHOWN)}</div></fieldset>
<fieldset><legend>Colour by</legend><div class="choice">{_choices('colour', COLOURS)}</div>
<div id="legend" class="legend"></div></fieldset>
<label class="check" id="arrow-box"><input type="checkbox" id="arrow" checked> next best
direction</label>
<p class="turn" id="turn" hidden></p>
<fieldset class="list"><legend>Views</legend>
<div class="all"><button type="button" id="all">all</button>
<button type="button" id="none">none</button> <small id="list-note"></small></div>
<div id="list"></div></fieldset>
</div>
</div>
<p class="keys" id="keys">{text(HELP)}</p>
"""


def _choices(group: str, names: dict[str, str]) -> str:
    return ''.join(
        f'<button type="button" data-{group}="{name}" aria-pressed="false">{text(title)}</button>'
        for name, title in names.items())


def _button(name: str, title: str, sign: str) -> str:
    return (f'<button type="button" id="{name}" title="{text(title)}" '
            f'aria-label="{text(title)}">{sign}</button>')
