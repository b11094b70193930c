"""The plots of the report, by the id of the place where they stand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexhex.experiments import experiment
from flexhex.fmus.common.model.parameters import parameters
from flexhex.output.page import linked, marked
from flexhex.output.plots import (
    COLOURS,
    Figure,
    figure,
    moving_rms,
    of_joint,
    per_joint,
    spectrum,
    trace,
)
from flexhex.run import loop
from flexhex.run.outcome import Outcome, PaperRun, Rows
from flexhex.simulation.cases import SETTLE

LOG = {"type": "log", "dtick": 1}
TIME, RUN = "time [s]", "run"
"""Title of a time axis; the group of those that are zoomed together."""
SHOWN = 10.0
"""Time of the plot of torques [s]."""
POINTS = 1200
"""Points of a line of which there is one for each joint."""
PAPER_ROWS = {
    "feedback": "feedback only",
    "fixed": "fixed",
    "adaptive": "adaptive",
    "repeatability": "non-repeatable",
}


def figures(run: PaperRun) -> dict[str, Figure]:
    """All plots of a run."""
    drawn: dict[str, Figure] = {"bode": loop.bode(run.builder.machine)}
    if run.table:
        timed = {
            "error": _error(run),
            "torque": _torque(run.adaptive),
            "joints": _joints(run),
            "adapting": _parameters(run),
        }
        drawn |= {name: linked(one, RUN) for name, one in timed.items()}
        drawn |= {"spectrum": _spectrum(run), "sources": _sources(run)}
    if run.table.published:
        drawn |= {
            "paper-e": _beside(run, 0, "Tracking error", "e [µrad]"),
            "paper-tau": _beside(run, 1, "Feedback torque", "τ<sub>FB</sub> [N m]"),
        }
    for name, result in run.experiments.items():
        drawn |= experiment(name).figures(result)
    return drawn


def _judged(outcome: Outcome, signal: str) -> tuple[Any, Any, float]:
    """Time after the settling time [s], samples, sample time [s] of a signal."""
    group = outcome.result.group(signal)
    keep = group.time > SETTLE
    t = np.asarray(group.time)[keep] - SETTLE
    return t, np.asarray(group.signals[signal])[keep], float(t[1] - t[0])


def _error(run: PaperRun) -> Figure:
    lines = []
    for outcome in run.compared:
        t, e, ts = _judged(outcome, "feedback.e")
        colour = COLOURS[outcome.case.name]
        lines.append(trace(t, moving_rms(e, ts) * 1e6, outcome.case.title, colour))
    title = "Tracking error, RMS over the joints in a 0.25 s window"
    return figure(title, TIME, "e [µrad]", lines, yaxis=LOG)


def _torque(outcome: Outcome) -> Figure:
    t, tau, _ = _judged(outcome, "feedback.tau")
    _, fb, _ = _judged(outcome, "feedback.tau_fb")
    _, ff, _ = _judged(outcome, "F.tau_ff")
    ff = np.repeat(ff, max(1, round(len(tau) / len(ff))), axis=0)[: len(tau)]
    keep = np.flatnonzero(t[: len(ff)] < SHOWN)
    lines = []
    for i in range(tau.shape[1]):
        three = [
            # beneath the feedforward, which is nearly all of it
            trace(t[keep], tau[keep, i], "total", "#9dc3e6", points=POINTS),
            trace(t[keep], ff[keep, i], "feedforward", "#1b1b1b", points=POINTS),
            trace(t[keep], fb[keep, i] * 10, "feedback × 10", "#c33", points=POINTS),
        ]
        three[0]["line"]["width"], three[1]["line"]["dash"] = 5, "dot"
        lines += [of_joint(i + 1, line) for line in three]
    title = f"Torque of joint {{joint}}, {outcome.case.title}"
    return per_joint(figure(title, TIME, "torque [N m]", lines))


def _joints(run: PaperRun) -> Figure:
    lines = []
    for outcome in run.compared[1:]:
        t, e, _ = _judged(outcome, "feedback.e")
        name, colour = outcome.case.title, COLOURS[outcome.case.name]
        lines += [
            of_joint(i + 1, trace(t, e[:, i] * 1e6, name, colour, points=POINTS))
            for i in range(e.shape[1])
        ]
    return per_joint(figure("Error of joint {joint}", TIME, "e [µrad]", lines))


def _spectrum(run: PaperRun) -> Figure:
    lines = []
    for outcome in run.compared:
        _, e, ts = _judged(outcome, "feedback.e")
        f, density = spectrum(e * 1e6, ts)
        keep = f < 300
        lines.append(trace(f[keep], density[keep], outcome.case.title, COLOURS[outcome.case.name]))
    unit = "e [µrad/√Hz]"
    return figure("Spectrum of the error", "frequency [Hz]", unit, lines, xaxis=LOG, yaxis=LOG)


def _parameters(run: PaperRun) -> Figure:
    """Estimates of the adaptive run against the fit, relative to the size of each parameter."""
    outcome, machine = run.adaptive, run.builder.machine
    listed = parameters(machine)
    t, p, _ = _judged(outcome, "K.p")
    scale = np.maximum(np.abs(run.fit.p), [par.floor for par in listed])
    moved = (p - run.fit.p) / scale
    most = np.argsort(-np.abs(moved).max(axis=0))[:8]
    lines = [trace(t, moved[:, k] * 100, listed[k].name) for k in most]
    title = "The eight parameters that adapt most, change relative to the fit"
    return figure(title, TIME, "change [%]", lines)


def _sources(run: PaperRun) -> Figure:
    """RMS errors from the adaptive loop down to what numerics and delays leave."""
    apart, rows = run.table.of("repeatability").figures.e, list[tuple[str, float, str]]()
    rows += [(o.case.title, o.figures.e, COLOURS[o.case.name]) for o in run.compared[1:]]
    missing = run.experiments.get("missing")
    if missing and missing.rebuilt and "machine" in missing.rebuilt.loops:
        after = missing.rebuilt.loops["machine"][1].e
        rows.append(("adaptive, with the effects<br>that the diagnosis found", after, "#3a8a4d"))
    rows.append(("non-repeatable part<br>of fixed feedforward", apart, "#8a6a4f"))
    exact = [o for o in run.extra if o.case.name == "exact-adaptive"]
    rows += [("adaptive, exact plant", o.figures.e, "#777") for o in exact]
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": [title for title, _, _ in rows][::-1],
        "x": [float(f"{e:.4g}") for _, e, _ in rows][::-1],
        "marker": {"color": [colour for _, _, colour in rows][::-1]},
        "text": [f"{e:.1f}" for _, e, _ in rows][::-1],
        "textposition": "outside",
        "cliponaxis": False,
        "hovertemplate": "%{x} µrad<extra></extra>",
        "showlegend": False,
        "name": "e",
    }
    return figure(
        "Tracking error, RMS",
        "e [µrad]",
        "",
        [bars],
        yaxis={"automargin": True},
        margin={"r": 45, "l": 20},
        height=110 + 42 * len(rows),
    )


def _beside(run: PaperRun, place: int, title: str, axis: str) -> Figure:
    """Simulated and published figures of each row as dots, both halves of the table."""
    halves = [("", run.table)]
    if run.actuators:
        halves.append(("actuators alone,<br>", run.actuators))
    ours: list[tuple[str, float]] = []
    theirs: list[tuple[str, float]] = []
    for prefix, rows in halves:
        for name, text in PAPER_ROWS.items():
            values = _pair(rows, name, place)
            if values:
                ours.append((prefix + text, values[0]))
                theirs.append((prefix + text, values[1]))
    colour = COLOURS["adaptive"]
    gaps = [
        {"x": [a, b], "y": [name, name], "mode": "lines", "line": {"color": "#bbb", "width": 2}}
        | {"showlegend": False, "hoverinfo": "skip", "meta": {"joins": True}}
        for (name, a), (_, b) in zip(ours, theirs, strict=True)
    ]
    dots = [
        _dots("published", theirs, {"symbol": "circle-open", "size": 12, "line": {"width": 2}}),
        _dots("simulated", ours, {"symbol": "circle", "size": 9, "color": colour}),
    ]
    dots[0]["marker"]["color"] = "#c0603a"
    order = [name for name, _ in ours][::-1]
    drawn = figure(
        title,
        axis,
        "",
        [*gaps, *dots],
        xaxis={"type": "log", "dtick": 1, "tickangle": 0},
        yaxis={"automargin": True, "categoryorder": "array", "categoryarray": order},
        margin={"l": 20, "r": 15, "t": 90},
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        height=160 + 38 * len(order),
        hovermode="closest",
    )
    return marked(drawn, half=True)


def _pair(rows: Rows, name: str, place: int) -> tuple[float, float] | None:
    known = rows.published.rows.get(name) if rows.published else None
    values = [o.figures.row()[place] for o in rows.outcomes if o.case.name == name]
    return (values[0], known[place]) if known and values else None


def _dots(name: str, rows: Sequence[tuple[str, float]], marker: dict[str, Any]) -> dict[str, Any]:
    return {
        "x": [float(f"{value:.4g}") for _, value in rows],
        "y": [title for title, _ in rows],
        "name": name,
        "mode": "markers",
        "marker": marker,
        "hovertemplate": f"{name}: %{{x}}<extra></extra>",
    }
