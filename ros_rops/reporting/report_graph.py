# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The graph of an object's views as SVG: who overlaps whom, and how well they agree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

from ros_rops.reporting.picture import PALETTE
from ros_rops.reporting.report_files import Document, items_of, RunFiles
from ros_rops.reporting.report_html import figure, Lengths, note, percent, text
from ros_rops.reporting.report_scene import number_of

WIDTH, HEIGHT, RING = 460, 400, 150
LONGEST_LABEL, MOST_NAMED = 16, 24
"""With longer names, or more, the numbers of the views stand alone."""
SHADES = ('#2c7fb8', '#7a8fb8', '#b58a3c', '#d95f0e', '#b3123c')
"""Of edges, from the best residual to the worst."""


@dataclass(frozen=True, slots=True)
class Edge:
    """Two views by their place in the object's list, and how they fit (None: not known)."""

    a: int
    b: int
    overlap: float | None
    residual: float | None


def hex_colour(place: int) -> str:
    """Return the colour of a view by its place in the object's list, as in picture.png."""
    return '#' + ''.join(f'{round(255 * v):02x}' for v in PALETTE[place % len(PALETTE)])


def graph(files: RunFiles, item: Document) -> str:
    """Return the graph of an object of `poses.json`; a sentence where nothing is known of it."""
    names = [str(view['name']) for view in item['views']]
    edges, source = edges_of(files, int(item['id']), names)
    if not edges:
        return note('The view graph is not known: neither quality.json nor trace.json tells '
                    'which views of this object were compared.')
    lengths = Lengths(files.units)
    residuals = sorted(edge.residual for edge in edges if edge.residual is not None)
    lines = ''.join(_line(edge, names, residuals, lengths) for edge in edges)
    places = [_place(k, len(names)) for k in range(len(names))]
    shown = [files.shown.get(name, name) for name in names]
    named = len(names) <= MOST_NAMED and max(map(len, shown)) <= LONGEST_LABEL
    nodes = ''.join(
        _node(name, k, places[k], files.numbers.get(name, -1), named=named)
        for k, name in enumerate(names))
    return (
        f'<figure class="graph"><svg viewBox="0 0 {WIDTH} {HEIGHT}" role="group" '
        f'aria-label="View graph of object {item["id"]}">{lines}{nodes}</svg>\n'
        f'<figcaption>{_caption(edges, residuals, lengths)} From {source}.</figcaption>'
        '</figure>\n')


def edges_of(
    files: RunFiles, object_id: int, names: Sequence[str]
) -> tuple[list[Edge], str]:
    """Return the edges between an object's views, and the file that tells of them."""
    place = {name: k for k, name in enumerate(names)}
    found = items_of(files.quality_of(object_id), 'edges')
    source = 'quality.json'
    if not found:
        found, source = _tried(files), 'trace.json: pairs that were accepted on the way'
    edges: dict[tuple[int, int], Edge] = {}
    for one in found:
        a, b = place.get(str(one.get('source'))), place.get(str(one.get('target')))
        if a is not None and b is not None and a != b:
            edges[min(a, b), max(a, b)] = Edge(
                min(a, b), max(a, b), number_of(one.get('overlap')),
                number_of(one.get('residual')))
    return [edges[key] for key in sorted(edges)], source


def _tried(files: RunFiles) -> list[Mapping[str, Any]]:
    resolution = number_of(files.poses.get('mesh_resolution'))
    found: list[Mapping[str, Any]] = []
    for one in items_of(files.trace, 'attempts'):
        numbers = one.get('numbers')
        if one.get('status') == 'placed' and isinstance(numbers, Mapping):
            residual = number_of(numbers.get('residual_mr'))
            if residual is not None:
                residual = None if resolution is None else residual * resolution
            found.append({
                'source': one.get('source'), 'target': one.get('target'),
                'overlap': numbers.get('overlap'), 'residual': residual})
    return found


def _place(k: int, count: int) -> tuple[float, float]:
    angle = 2 * math.pi * k / max(count, 1) - math.pi / 2
    return WIDTH / 2 + RING * math.cos(angle), HEIGHT / 2 + RING * math.sin(angle)


def _line(
    edge: Edge, names: Sequence[str], residuals: Sequence[float], lengths: Lengths
) -> str:
    (x1, y1), (x2, y2) = _place(edge.a, len(names)), _place(edge.b, len(names))
    thick = 1.0 if edge.overlap is None else 0.6 + 5.0 * min(max(edge.overlap, 0.0), 1.0)
    told = (f'{names[edge.a]} – {names[edge.b]}: overlap {percent(edge.overlap)}, '
            f'residual {lengths.text(edge.residual)}')
    at = f'x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"'
    return (
        f'<g class="edge" data-a="{edge.a}" data-b="{edge.b}" data-told="{text(told)}">'
        f'<title>{text(told)}</title><line {at} stroke="{_shade(edge.residual, residuals)}" '
        f'stroke-width="{thick:.1f}"/><line {at} class="hit"/></g>\n')


def _shade(residual: float | None, residuals: Sequence[float]) -> str:
    if residual is None or not residuals:
        return '#999999'
    low, high = residuals[0], residuals[-1]
    share = (residual - low) / (high - low) if high > low else 0.0
    return SHADES[min(int(share * len(SHADES)), len(SHADES) - 1)]


def _node(name: str, k: int, at: tuple[float, float], number: int, *, named: bool) -> str:
    x, y = at
    out_x, out_y = (x - WIDTH / 2) / RING, (y - HEIGHT / 2) / RING
    anchor = 'start' if out_x > 0.3 else 'end' if out_x < -0.3 else 'middle'
    shown = '' if not named else (
        f'<text class="label" x="{x + 17 * out_x:.1f}" y="{y + 20 * out_y + 4:.1f}" '
        f'text-anchor="{anchor}">{text(name)}</text>')
    ink = '#ffffff' if sum(PALETTE[k % len(PALETTE)]) < 1.6 else '#111111'
    return (
        f'<g class="node" tabindex="0" role="button" data-view="{number}" data-place="{k}" '
        f'aria-label="view {number}, {text(name)}"><title>{text(name)}</title>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="10" fill="{hex_colour(k)}"/>'
        f'<text class="id" x="{x:.1f}" y="{y + 3.5:.1f}" fill="{ink}">{number}</text>{shown}'
        '</g>\n')


def _caption(edges: Sequence[Edge], residuals: Sequence[float], lengths: Lengths) -> str:
    said = f'{figure(len(edges))} pair{"" if len(edges) == 1 else "s"} of views'
    if residuals:
        bar = ''.join(f'<i style="background:{shade}"></i>' for shade in SHADES)
        said += (f'; residual {lengths.bare(residuals[0])} <span class="shades">{bar}</span> '
                 f'{lengths.text(residuals[-1])}')
    return said + '; the thicker, the more they overlap.'
