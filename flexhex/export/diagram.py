"""The diagram of a .ssp as an SVG file."""

from __future__ import annotations

import html
import itertools
from collections.abc import Sequence
from pathlib import Path

from flexhex.ssp.diagram import Diagram, Line, Point, Shape, read_diagram, symbol

MARGIN = 24.0
_HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}"'
    ' width="{width:g}" height="{height:g}" font-family="system-ui, sans-serif" font-size="13">\n'
    "<title>{name}</title>\n"
    '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8"'
    ' orient="auto"><path d="M0 0.5 8 4 0 7.5z" fill="#444"/></marker></defs>\n'
    '<rect width="{width:g}" height="{height:g}" fill="white"/>\n'
)


def export_diagram(path: Path, target: Path) -> Path:
    """Draw a .ssp; InterfaceError when it has no coordinates."""
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(svg(read_diagram(path)), encoding="utf-8")
    return target


def svg(diagram: Diagram) -> str:
    """The drawing; y, which points up in a .ssp, points down here."""
    corners = [point for line in diagram.lines for point in line.points]
    corners += [(s.left, s.bottom) for s in diagram.shapes]
    corners += [(s.right, s.top) for s in diagram.shapes]
    left, top = min(x for x, _ in corners) - MARGIN, max(y for _, y in corners) + MARGIN
    width = max(x for x, _ in corners) + MARGIN - left
    height = top - min(y for _, y in corners) + MARGIN

    def place(point: Point) -> Point:
        return (point[0] - left, top - point[1])

    text = [_HEAD.format(width=width, height=height, name=html.escape(diagram.name))]
    text += [_line([place(p) for p in line.points]) for line in diagram.lines]
    text += [_box(shape, *place((shape.left, shape.top))) for shape in diagram.shapes]
    text += [_label(line, [place(p) for p in line.points]) for line in diagram.lines]
    return "".join([*text, "</svg>\n"])


def _line(points: Sequence[Point]) -> str:
    path = " ".join(f"{x:g} {y:g}" for x, y in points)
    return f'<path d="M{path}" fill="none" stroke="#444" marker-end="url(#tip)"/>\n'


def _box(shape: Shape, x: float, y: float) -> str:
    width, height = shape.right - shape.left, shape.top - shape.bottom
    middle, rate = x + width / 2, "" if shape.period is None else _rate(shape.period)
    small = [text for text in (shape.fmu if shape.fmu != shape.name else "", rate) if text]
    rows = "".join(
        f'<text x="{middle:g}" y="{y + height / 2 + 14 + 15 * k:g}" text-anchor="middle"'
        f' font-size="11" fill="#555">{html.escape(text)}</text>\n'
        for k, text in enumerate(small)
    )
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="#eef4fa"'
        ' stroke="#1f6fb2"/>\n'
        f'<text x="{middle:g}" y="{y + height / 2 - 5:g}" text-anchor="middle" font-weight="600"'
        f' fill="#222">{_indexed(shape.name)}</text>\n{rows}'
    )


def _rate(period: float) -> str:
    rate = 1 / period
    return f"{rate / 1000:.3g} kHz" if rate >= 1000 else f"{rate:.3g} Hz"


def _label(line: Line, points: Sequence[Point]) -> str:
    """Above the longest level stretch; beside the longest upright one when that is short."""
    text = ", ".join(_indexed(symbol(name)) for name in line.names)
    wide = 7.0 * sum(len(symbol(name)) + 2 for name in line.names)
    stretches = list(itertools.pairwise(points))
    level = max(stretches, key=lambda s: abs(s[1][0] - s[0][0]))
    upright = max(stretches, key=lambda s: abs(s[1][1] - s[0][1]))
    if abs(level[1][0] - level[0][0]) >= min(wide, 60.0):
        x, y, anchor = (level[0][0] + level[1][0]) / 2, level[0][1] - 6, "middle"
    else:
        x, y, anchor = upright[0][0] - 6, (upright[0][1] + upright[1][1]) / 2 + 4, "end"
    return (
        f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="12" fill="#222"'
        f' stroke="white" stroke-width="4" paint-order="stroke">{text}</text>\n'
    )


def _indexed(name: str) -> str:
    """`N_F` with its index lowered."""
    letter, _, index = name.partition("_")
    if not index:
        return html.escape(letter)
    low = f'<tspan dy="3" font-size="75%">{html.escape(index)}</tspan><tspan dy="-3">\u200b</tspan>'
    return f"{html.escape(letter)}{low}"
