"""Diagram of a .ssp from its own coordinates: boxes, and one line for all wires between two."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flexhex.fmus.common.archive import open_zip, read_member
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import array_of
from flexhex.ssp.system import Box
from flexhex.ssp.xml import NAMESPACES, parse

Point = tuple[float, float]


@dataclass(frozen=True)
class Shape:
    """A component: name, FMU, period [s] if declared; box as in `Component`, y up."""

    name: str
    fmu: str
    period: float | None
    box: Box

    @property
    def left(self) -> float:
        """Smallest x."""
        return min(self.box[0], self.box[2])

    @property
    def right(self) -> float:
        """Largest x."""
        return max(self.box[0], self.box[2])

    @property
    def bottom(self) -> float:
        """Smallest y."""
        return min(self.box[1], self.box[3])

    @property
    def top(self) -> float:
        """Largest y."""
        return max(self.box[1], self.box[3])


@dataclass(frozen=True)
class Line:
    """All connections from one component to another: names of the outputs, corners."""

    source: str
    target: str
    names: tuple[str, ...]
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Diagram:
    """What a .ssp says of how it looks."""

    name: str
    shapes: tuple[Shape, ...]
    lines: tuple[Line, ...]


def read_diagram(path: str | Path) -> Diagram:
    """Boxes and lines of a .ssp; its lines end evenly spaced on the sides of the boxes.

    Raises InterfaceError when it cannot be read or a component has no place.
    """
    archive = open_zip(path, str(path))
    text = read_member(archive, "SystemStructure.ssd", str(path))
    document = parse(text, f"{path}: SystemStructure.ssd")
    shapes = tuple(_shapes(document, str(path)))
    wires = list(document.iterfind("ssd:System/ssd:Connections/ssd:Connection", NAMESPACES))
    pairs: dict[tuple[str, str], list[Any]] = {}
    for wire in wires:
        pairs.setdefault((wire.get("startElement"), wire.get("endElement")), []).append(wire)
    known = {shape.name: shape for shape in shapes}
    lines = [_line(known[a], known[b], signals) for (a, b), signals in pairs.items()]
    return Diagram(str(document.get("name")), shapes, tuple(_spread(known, lines)))


def _shapes(document: Any, path: str) -> list[Shape]:
    schedule = document.find(".//flexhex:Schedule", NAMESPACES)
    base = 0.0 if schedule is None else float(schedule.get("baseStep"))
    entries = [] if schedule is None else schedule.iterfind("flexhex:Period", NAMESPACES)
    periods = {e.get("component"): int(e.get("steps")) * base for e in entries}
    shapes = []
    for element in document.iterfind("ssd:System/ssd:Elements/ssd:Component", NAMESPACES):
        name, place = element.get("name"), element.find("ssd:ElementGeometry", NAMESPACES)
        if place is None:
            raise InterfaceError(f"{path}: {name} has no ssd:ElementGeometry, so no place")
        x1, y1, x2, y2 = (float(place.get(key)) for key in ("x1", "y1", "x2", "y2"))
        fmu = Path(element.get("source")).stem
        shapes.append(Shape(name, fmu, periods.get(name), (x1, y1, x2, y2)))
    return shapes


def _line(source: Shape, target: Shape, wires: Sequence[Any]) -> Line:
    """Corners of the first wire's geometry; without one, straight or over the top."""
    arrays = [array_of(wire.get("startConnector")) for wire in wires]
    geometry = wires[0].find("ssd:ConnectionGeometry", NAMESPACES)
    start = (source.box[2], (source.bottom + source.top) / 2)
    end = (target.box[0], (target.bottom + target.top) / 2)
    if geometry is not None:
        x, y = ([float(v) for v in geometry.get(key).split()] for key in ("pointsX", "pointsY"))
        corners = list(zip(x, y, strict=True))
    elif (end[0] - start[0]) * (source.box[2] - source.box[0]) > 0:
        middle = (start[0] + end[0]) / 2
        corners = [(middle, start[1]), (middle, end[1])]
    else:
        over = max(source.top, target.top) + 25
        corners = [(start[0] + 25, start[1]), (start[0] + 25, over)]
        corners += [(end[0] - 25, over), (end[0] - 25, end[1])]
    names = tuple(dict.fromkeys(arrays))
    return Line(source.name, target.name, names, (start, *corners, end))


_SMALL_STEP = 35.0


def _spread(shapes: dict[str, Shape], lines: Sequence[Line]) -> list[Line]:
    """Lines moved to places of their own on the sides of the boxes, so that few cross."""
    heights: dict[tuple[int, int], float] = {}
    company: dict[tuple[int, int], int] = {}
    for name, shape in shapes.items():
        for end in (0, -1):
            here = [k for k, line in enumerate(lines) if (line.source, line.target)[end] == name]
            here.sort(key=lambda k, e=end, s=shape: _rank(lines[k], e, s))  # type: ignore[misc]
            for place, k in enumerate(here, start=1):
                share = place / (len(here) + 1)
                heights[k, end] = shape.top - share * (shape.top - shape.bottom)
                company[k, end] = len(here)
    for k, line in enumerate(lines):
        # a line alone on a side meets the other end's height where that spares a small step
        for end, other in ((0, -1), (-1, 0)):
            step = abs(heights[k, 0] - heights[k, -1])
            if company[k, end] == 1 and len(line.points) == 4 and step < _SMALL_STEP:
                heights[k, end] = heights[k, other]
    return [_moved(line, heights[k, 0], heights[k, -1]) for k, line in enumerate(lines)]


def _rank(line: Line, end: int, shape: Shape) -> float:
    """From top to bottom: lines that come from above, nearest first; from below, nearest last."""
    points = line.points if end == 0 else line.points[::-1]
    distance = 1 / (1 + abs(points[1][0] - points[0][0]))
    away = points[2][1] if len(points) > 3 else points[-1][1]
    middle = (shape.top + shape.bottom) / 2
    return 0.0 if shape.bottom < away < shape.top else (-distance if away > middle else distance)


def _moved(line: Line, first: float, last: float) -> Line:
    inner = list(line.points[1:-1])
    inner[0] = (inner[0][0], first)
    inner[-1] = (inner[-1][0], last)
    start, end = (line.points[0][0], first), (line.points[-1][0], last)
    points = [start, *inner, end]
    if first == last and len(inner) == 2:
        points = [start, end]
    return replace(line, points=tuple(points))


_DOTS = re.compile(r"(.*?)(_f)?(dd|d)?")


def symbol(name: str) -> str:
    """A variable's name as the paper writes it, with its index after `_`: `theta_fd` is θ̇_f."""
    match = _DOTS.fullmatch(name)
    stem, dots = (match[1], match[3]) if match else (name, None)
    filtered = "_f" if match and match[2] else ""
    if stem not in _LETTERS:
        return name
    letter, _, index = _LETTERS[stem].partition("_")
    mark = {"d": "\u0307", "dd": "\u0308"}.get(dots or "", "")
    index = index or filtered.removeprefix("_")
    return f"{letter}{mark}{f'_{index}' if index else ''}"


_LETTERS = {
    "r": "r", "x": "x", "z": "z", "p": "p̂", "theta": "θ", "tau": "τ", "chi": "χ",
    "tau_ff": "τ_FF", "tau_meas": "τ_meas",
}  # fmt: skip
