"""How the parameters are shown: table rows with drawn trajectories, and two plots."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np

from flexhex.experiments.estimates import Estimates
from flexhex.output.plots import COLOURS, Figure, figure
from flexhex.output.tables import Column, printed
from flexhex.simulation.runs import Array

EDGE = 30.0
"""Deviations beyond this [%] are drawn at the edge of the plot."""
SPARK = (110, 22, 40)
"""Size of a drawn trajectory in the table [px] and its number of points."""
TIME_POINTS, FIRST_SHOWN = 200, "end-effector"
"""Points of a trajectory in the plot, and the body that it shows at first."""
EDGE_COLOUR = "#aaa"
CYCLE, DASHES = 8, ("solid", "dash", "dot")
"""Colours of the page's lines before the first comes again, in the next of these dashes."""
COLUMNS = (
    Column("name", "parameter"),
    Column("body", "body"),
    Column("unit", "unit"),
    Column("cold", "true, cold", number=".4g"),
    Column("fit", "fit", number=".4g"),
    Column("std", "± std", number=".1g"),
    Column("warm", "true, warm", number=".4g"),
    Column("adapted", "adapted", number=".4g"),
    Column("adapted_std", "± std", number=".1g"),
)


def rows(result: Estimates) -> list[dict[str, Any]]:
    """One row a parameter: what the table shows, `spark` is its trajectory as a drawing."""
    listed = []
    for k, par in enumerate(result.listed):
        listed.append(
            {
                "name": par.name,
                "unit": printed(par.unit),
                "body": par.body,
                "fit": result.fit[k],
                "std": result.std[k],
                "cold": result.cold[k],
                "adapted": result.p[-1, k],
                "adapted_std": result.p_std[-1, k],
                "warm": result.warm[k],
                "loose": par.name in result.loose,
                "spark": spark(result, k),
            }
        )
    return listed


def figures(result: Estimates) -> dict[str, Figure]:
    """Distance from the truth of all parameters; trajectories, one body at a time."""
    return {"estimates-truth": _truth(result), "estimates-time": _time(result)}


def spark(result: Estimates, k: int) -> str:
    """Trajectory of parameter k as SVG: its line, +-std shaded, the warm machine's value dashed.

    The picture's range is that of the line and the truth; the shade may leave it.
    """
    width, height, points = SPARK
    at = np.linspace(0, len(result.t) - 1, min(points, len(result.t))).astype(int)
    p, std, truth = result.p[at, k], result.p_std[at, k], result.warm[k]
    low, high = min(p.min(), truth), max(p.max(), truth)
    span = max(high - low, 1e-3 * result.scale[k])
    x = np.linspace(0, width, len(at))

    def y(value: Array) -> Array:
        at = height - 3 - (height - 6) * (value - low) / span
        return np.asarray(np.clip(at, -height, 2 * height))

    def path(xs: Array, ys: Array) -> str:
        return " ".join(f"{a:.0f},{b:.1f}" for a, b in zip(xs, ys, strict=True))

    band = path(np.concatenate([x, x[::-1]]), np.concatenate([y(p - std), y(p + std)[::-1]]))
    true = f"{float(y(np.array(truth))):.1f}"
    return (
        f'<svg width="{width}" height="{height}" style="overflow:hidden;vertical-align:middle">'
        f'<polygon points="{band}" fill="#1f6fb2" opacity="0.15"/>'
        f'<line x1="0" x2="{width}" y1="{true}" y2="{true}" stroke="#222" stroke-dasharray="3 3"/>'
        f'<polyline points="{path(x, y(p))}" fill="none" stroke="#1f6fb2" stroke-width="1.2"/>'
        "</svg>"
    )


def _groups(result: Estimates) -> list[tuple[str, list[int]]]:
    """Indices of the parameters by body; the arms' own inertias count with the upper arms."""

    def body(k: int) -> str:
        name = result.listed[k].body
        return "upper arms" if name.startswith("upper") else name

    return [(name, list(ks)) for name, ks in groupby(range(len(result.listed)), key=body)]


def _truth(result: Estimates) -> Figure:
    groups, n = _groups(result), len(result.listed)
    loose = np.array([par.name in result.loose for par in result.listed])
    traces = [
        _dots(result, (result.fit, result.std, result.cold), -0.18, "fit", COLOURS["fixed"], loose),
        _dots(
            result,
            (result.p[-1], result.p_std[-1], result.warm),
            0.18,
            "adapted",
            COLOURS["adaptive"],
            loose,
        ),
    ]
    ticks = [float(np.mean(ks)) for _, ks in groups]
    edges = [
        {"type": "line", "x0": ks[-1] + 0.5, "x1": ks[-1] + 0.5, "y0": 0, "y1": 1}
        | {"yref": "paper", "line": {"color": EDGE_COLOUR, "width": 0.7}}
        for _, ks in groups[:-1]
    ]
    axis = {
        "tickvals": ticks,
        "ticktext": [name for name, _ in groups],
        "tickangle": -30,
        "showgrid": False,
        "range": [-1, n],
    }
    title = "Estimates minus truth, bars of one standard deviation; hollow: not determined"
    y = {"range": [-1.06 * EDGE, 1.06 * EDGE], "zeroline": True}
    margin = {"b": 80}
    return figure(
        title, "", "error [% of scale]", traces, xaxis=axis, yaxis=y, shapes=edges, margin=margin
    )


def _dots(
    result: Estimates,
    values: tuple[Array, Array, Array],
    shift: float,
    name: str,
    colour: str,
    loose: Any,
) -> dict[str, Any]:
    """Markers with bars of one kind of estimate (estimate, std, truth), at the edge if beyond."""
    estimate, std, truth = values
    off = 100 * (estimate - truth) / result.scale
    beyond = np.abs(off) > EDGE
    shapes = np.where(beyond, np.where(off > 0, "triangle-up", "triangle-down"), "circle")
    symbols = [f"{s}-open" if open_ else str(s) for s, open_ in zip(shapes, loose, strict=True)]
    bars = np.where(beyond, 0.0, np.minimum(100 * std / result.scale, 4 * EDGE))
    return {
        "x": [round(k + shift, 2) for k in range(len(off))],
        "y": [float(f"{v:.4g}") for v in np.clip(off, -EDGE, EDGE)],
        "error_y": {
            "type": "data",
            "array": [float(f"{v:.3g}") for v in bars],
            "thickness": 0.7,
            "width": 0,
        },
        "text": [par.name for par in result.listed],
        "customdata": [float(f"{v:.4g}") for v in off],
        "hovertemplate": "%{text}: %{customdata} %<extra>" + name + "</extra>",
        "name": name,
        "mode": "markers",
        "marker": {"color": colour, "size": 5, "symbol": symbols},
    }


def _time(result: Estimates) -> Figure:
    every = max(1, len(result.t) // TIME_POINTS)
    moved = 100 * (result.p[::every] - result.fit) / result.scale
    step = every * float(result.t[1] - result.t[0])
    groups = _groups(result)
    names = [name for name, _ in groups]
    shown = names.index(FIRST_SHOWN) if FIRST_SHOWN in names else 0
    traces = [
        {"x0": float(result.t[0]), "dx": step, "y": [float(f"{v:.3g}") for v in moved[:, k]]}
        | {"name": result.listed[k].name, "mode": "lines"}
        | {"line": {"width": 1.2, "dash": DASHES[place // CYCLE % len(DASHES)]}}
        | {"visible": g == shown}
        for g, (_, ks) in enumerate(groups)
        for place, k in enumerate(ks)
    ]
    owner = [g for g, (_, ks) in enumerate(groups) for _ in ks]
    buttons = [
        {"label": name, "method": "update", "args": [{"visible": [o == g for o in owner]}]}
        for g, (name, _) in enumerate(groups)
    ]
    menu = {"buttons": buttons, "active": shown, "x": 1.02, "xanchor": "left", "y": 1}
    title = "Trajectories of the estimates, change relative to the fit; choose a body"
    legend = {"y": 0.86}
    return figure(
        title,
        "time [s]",
        "change [% of scale]",
        traces,
        updatemenus=[menu],
        legend=legend,
        height=420,
    )
