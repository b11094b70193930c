"""Figures of a diagnosis: residual, gains of candidates, torque over time, heat tables."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.titles import effort, title, where
from flexhex.diagnosis.result.pictured import Candidate, Strip
from flexhex.output.plots import Figure, figure, of_joint, per_joint, rounded, trace

Array = NDArray[np.float64]
BEFORE, AFTER, NON_REPEATABLE, OTHER, INK = "#d1731d", "#1f6fb2", "#333", "#b5b5b5", "#222"
STRIP = 2000
"""Points of a line over time."""
CELL = "31,111,178"
"""Colour of a full cell; a lesser one lets the ground through, light or dark."""
MOST_BARS = 10
"""Candidates of a round that are drawn."""
TOP = {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "font": {"size": 12}}
MARGIN = {"l": 70, "r": 15, "t": 75, "b": 50}
"""The legend stands above the plot, so that a narrow screen has room beside it."""
SMALL = 8
"""Columns of a heat table up to which they have names and all cells figures; else numbers."""
WRITTEN = 0.5
"""Cells from here on hold figures in a large table."""
FAINT, FAINTEST = 0.04, 0.005
"""Cells below this stay white in a large table, in a small one."""


def residual_bars(
    name: str,
    unit: str,
    before: Array,
    after: Array,
    non_repeatable: Array | None = None,
    names: Sequence[str] | None = None,
) -> Figure:
    """Before and after of each axis, or of `names`; a black line: non-repeatable."""
    axes = list(names or [f"axis {i + 1}" for i in range(len(before))])
    bars: list[dict[str, Any]] = [
        {"type": "bar", "x": axes, "y": rounded(v), "name": text, "marker": {"color": colour}}
        for v, text, colour in ((before, "before", BEFORE), (after, "after", AFTER))
    ]
    if non_repeatable is not None and np.isfinite(non_repeatable).any():
        wide = max(10, int(220 / len(axes)))
        mark = {"symbol": "line-ew", "size": wide, "line": {"width": 2.5, "color": NON_REPEATABLE}}
        line = {"x": axes, "y": rounded(non_repeatable), "mode": "markers", "marker": mark}
        bars.append({**line, "name": "non-repeatable"})
    spacing = max(0.35, 0.85 - 0.1 * len(axes))
    layout = {"barmode": "group", "bargap": spacing, "legend": TOP, "margin": MARGIN}
    label_y = f"RMS [{unit}]" if unit else "RMS"
    return figure(name, "", label_y, bars, yaxis={"rangemode": "tozero"}, **layout)


def candidate_bars(number: int, candidates: Sequence[Candidate]) -> Figure:
    """What each candidate of a round predicts, best on top: chosen, rivals, others."""
    # of those that are called the same, at other starting values, the best
    named = {label(c): c for c in sorted(candidates, key=lambda c: (c.chosen, c.rival, c.gain))}
    best = sorted(named.values(), key=lambda c: c.gain, reverse=True)[:MOST_BARS][::-1]
    kinds = [
        ("named", AFTER, [c for c in best if c.chosen]),
        ("indistinguishable", BEFORE, [c for c in best if c.rival and not c.chosen]),
        ("other", OTHER, [c for c in best if not (c.rival or c.chosen)]),
    ]
    bars = [
        {
            "type": "bar",
            "orientation": "h",
            "y": [label(c) for c in kind],
            "x": [float(f"{max(c.gain, 0.0):.4g}") for c in kind],
            "hovertext": [f"{100 * c.size:.2g} % of the torque" for c in kind],
            "name": text,
            "marker": {"color": colour},
        }
        for text, colour, kind in kinds
        if kind
    ]
    order = {"categoryorder": "array", "categoryarray": [label(c) for c in best]}
    return figure(
        f"Round {number}",
        "gain on left-out trajectories [nats]",
        "",
        bars,
        yaxis={**order, "automargin": True, "title": {"text": ""}, "tickfont": {"size": 11}},
        xaxis={"rangemode": "tozero"},
        legend={**TOP, "traceorder": "normal"},
        margin=MARGIN,
        height=165 + 30 * len(best),
        showlegend=True,
        barmode="stack",
    )


def label(c: Candidate) -> str:
    """`Coulomb friction, axis 3`; a long title goes on in a second line."""
    lines = textwrap.wrap(title(c.id), 24)
    place = where(c.axes, short=True).replace(" ", "\N{NO-BREAK SPACE}")
    if c.axes:
        lines[-1:] = textwrap.wrap(f"{lines[-1]}, {place}", 24)
    return "<br>".join(lines)


def strip_figures(strips: Sequence[Strip], first: int) -> dict[str, Figure]:
    """Torque and residual of all axes over time, one axis at a time, those of one unit in a figure;
    first: where it begins."""
    drawn = dict[str, Figure]()
    for k, unit in enumerate(dict.fromkeys(s.unit for s in strips)):
        torque, residual = _strip_lines([s for s in strips if s.unit == unit])
        called, number = effort([unit]), f"-{k + 1}" if k else ""
        over, left = f"{called.capitalize()} of axis {{joint}}", f"residual [{unit}]"
        beside = "Residual of axis {joint}, measured minus model"
        drawn[f"strip{number}"] = figure(over, "time [s]", f"{called} [{unit}]", torque)
        drawn[f"strip-residual{number}"] = figure(beside, "time [s]", left, residual, height=300)
    return {name: per_joint(one, "axis", first) for name, one in drawn.items()}


def _strip_lines(strips: Sequence[Strip]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Lines of torque, and of what each model leaves of it."""
    torque, residual = list[dict[str, Any]](), list[dict[str, Any]]()
    for s in strips:
        t, known = s.time - s.time[0], np.isfinite(s.measured)
        for values, name, colour in (
            (s.measured, "measured", INK),
            (s.before, "model before", BEFORE),
            (s.after, "model after", AFTER),
        ):
            line = trace(t[known], values[known], name, colour, points=STRIP)
            torque.append(of_joint(s.axis, line))
            if name != "measured":
                left = s.measured[known] - values[known]
                rest = trace(t[known], left, name.removeprefix("model "), colour, points=STRIP)
                residual.append(of_joint(s.axis, rest))
    return torque, residual


def heat(name: str, rows: Sequence[str], columns: Sequence[str], values: Array) -> Figure:
    """A table of shares 0..1 as colours; figures [%] in the cells where there is room."""
    shapes, notes = [], []
    small = len(columns) <= SMALL
    for (i, j), value in np.ndenumerate(values):
        if not math.isfinite(value) or value < (FAINTEST if small else FAINT):
            continue
        shapes.append(
            {
                "type": "rect",
                **{"x0": j - 0.5, "x1": j + 0.5, "y0": i - 0.5, "y1": i + 0.5},
                "line": {"width": 1, "color": "rgba(128,128,128,0.25)"},
                "fillcolor": shade(value),
                "layer": "below",
            }
        )
        if small or (value >= WRITTEN and i != j):
            shown = f"{100 * value:.0f}"
            colour = "white" if value > 0.55 else "#222"
            font = {"size": 12 if small else 9, "color": colour}
            notes.append({"x": j, "y": i, "text": shown, "showarrow": False, "font": font})
    # what the pointer shows; the colours themselves are shapes: plotly-basic has no heat maps
    places = list(np.ndindex(values.shape))
    numbers = [str(j + 1) for j in range(len(columns))]
    labels = rows if small else [f"{row}  {i}" for i, row in enumerate(rows, start=1)]
    hover = [f"{rows[i]} / {columns[j]}: {values[i, j]:.2g}" for i, j in places]
    dots = {
        "x": [j for _, j in places],
        "y": [i for i, _ in places],
        "mode": "markers",
        "marker": {"size": 16, "opacity": 0},
        "hovertext": hover,
        "hoverinfo": "text",
        "showlegend": False,
    }
    return figure(
        name,
        "",
        "",
        [dots],
        shapes=shapes,
        annotations=notes,
        xaxis=_ticks(columns if small else numbers, {"tickangle": -45 if small else 0}),
        yaxis=_ticks(labels, {"range": [len(rows) - 0.5, -0.5]}),
        height=130 + max(18, min(30, 700 // len(rows))) * len(rows),
        margin={**MARGIN, "t": 40},
    )


def _ticks(names: Sequence[str], more: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "tickvals": list(range(len(names))),
        "ticktext": list(names),
        "range": [-0.5, len(names) - 0.5],
        "automargin": True,
        "showgrid": False,
        "title": {"text": ""},
        "tickfont": {"size": 12 if len(names) <= SMALL else 10},
        **more,
    }


def shade(value: float) -> str:
    """Nothing at 0, blue at 1."""
    return f"rgba({CELL},{min(max(value, 0.0), 1.0):.3g})"
