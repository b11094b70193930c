"""How `flexhex identify` shows a simulation of runs from their torques: table and plots."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.numbers import number
from flexhex.diagnose.plots import AFTER, BEFORE, INK, OTHER, STRIP
from flexhex.diagnosis.estimation.forward.record import Model, Simulation
from flexhex.diagnosis.kinds import axes_named
from flexhex.output.page import PageSection
from flexhex.output.parts import Part, Sentence, Titled
from flexhex.output.plots import LOG, Figure, figure, of_joint, per_joint, trace
from flexhex.output.tables import Column, Value

Array = NDArray[np.float64]
MILLI = 1e3
"""Errors are told in mrad or mm."""
EARLY = 0.01
"""Time from which errors over time are drawn [s]."""
DECADES = {"type": "log", "tickvals": [10.0**k for k in range(-9, 10)],
           "ticktext": [f"{10.0**k:g}" for k in range(-9, 10)]}  # fmt: skip
NAMES = {"constant_rate": "constant rate", "file": "file", "fitted": "identified"}
COLOURS = {"constant_rate": OTHER, "file": BEFORE, "fitted": AFTER}
NO_FRICTION = " `file` is without friction."
WHOSE = {"file": "with the file's values", "fitted": "with the estimates"}


def simulation_parts(told: Simulation, called: str) -> list[Part]:
    """A table of errors after some times, and what a reader must know of it; called: the torque or
    force that drives."""
    models = {name: told.at(model) for name, model in told.models.items()}
    columns = [Column("axis", "axis"), Column("after", "after", right=True)]
    columns += [Column(name, NAMES[name], right=True) for name in models]
    rows = list[Mapping[str, Value]]()
    for i, unit in enumerate(told.units):
        for k, after in enumerate(told.horizons):
            errors = {name: number(MILLI * float(e[k, i])) for name, e in models.items()}
            axis = str(i + 1) if k == 0 else ""
            rows.append({"axis": axis, "after": f"{after:g} s", **errors, "unit": f"m{unit}"})
    columns.append(Column("unit", "unit"))
    of = "held-out runs" if told.held_out else "the runs"
    over = f"RMS of {told.windows} windows of {of}"
    title = f"Simulated from the measured {called}: error of the position ({over})"
    return [Titled(title, columns, rows), *(Sentence(text) for text in sentences(told))]


def sentences(told: Simulation) -> list[str]:
    """What a reader of the table must know."""
    bare = NO_FRICTION if told.file and told.bare else ""
    texts = [
        "Each window begins at the measured position and rate. `constant rate` keeps that rate: a"
        f" model that is worth something leaves less.{bare}"
    ]
    texts += [*_worse(told), *(_diverged(told, n, m) for n, m in told.models.items() if m.diverged)]
    if told.why:
        texts.append(f"{told.why[0].upper()}{told.why[1:]}.")
    if told.left_out:
        texts.append(f"Not in the simulation: {', '.join(told.left_out)}.")
    return texts


def _worse(told: Simulation) -> list[str]:
    """Where the estimates are worth nothing."""
    errors, constant = told.at(told.fitted), told.at(told.constant)
    listed = [
        f"after {after:g} s on {axes_named(np.flatnonzero(row))}"
        for after, row in zip(told.horizons, errors > constant, strict=True)
        if row.any()
    ]
    return [f"The estimates leave more than a constant rate {', '.join(listed)}."] if listed else []


def _diverged(told: Simulation, name: str, model: Model) -> str:
    return (
        f"{WHOSE.get(name, NAMES[name]).capitalize()} {model.diverged} of {told.windows} windows"
        f" diverged, the first after {model.first:.2g} s: farther off than the axis' whole range."
    )


def simulation_section(told: Simulation, called: str, first: int) -> PageSection:
    """Positions of a run's windows, and how errors grow; called: the torque or force that drives;
    first: axis that the plots begin with."""
    kind = "a held-out run" if told.held_out else "one of the runs that were fitted"
    text = (
        f"{Path(told.run).name}, {kind}: the positions that follow from the measured {called}, in"
        " windows that each begin at the measured position and rate; below, the error over the time"
        f" since then, RMS of {told.windows} windows."
    )
    if len(told.units) > 1:
        text += " The buttons choose the axis."
    drawn = dict[str, Figure]()
    for k, unit in enumerate(dict.fromkeys(told.units)):
        axes = [i for i, own in enumerate(told.units) if own == unit]
        number = f"-{k + 1}" if k else ""
        drawn[f"simulated{number}"] = _positions(told, axes, unit)
        drawn[f"simulated-error{number}"] = _growth(told, axes, unit)
    figures = {name: per_joint(one, "axis", first) for name, one in drawn.items()}
    return PageSection(f"Position, simulated from the {called}", text, figures=figures)


def _positions(told: Simulation, axes: list[int], unit: str) -> Figure:
    lines, t = list[dict[str, Any]](), told.time - told.time[0]
    for i in axes:
        sides = [("measured", INK, told.measured), *(
            (NAMES[name], COLOURS[name], model.line)
            for name, model in told.models.items() if name != "constant_rate"
        )]  # fmt: skip
        for name, colour, values in sides:
            lines.append(of_joint(i + 1, _line(t, values[:, i], name, colour)))
    return figure("Position of axis {joint}", "time [s]", f"position [{unit}]", lines)


def _growth(told: Simulation, axes: list[int], unit: str) -> Figure:
    lines = list[dict[str, Any]]()
    after: Array = told.dt * np.arange(len(told.constant.rms), dtype=np.float64)
    shown = slice(round(EARLY / told.dt), None)
    for i in axes:
        for name, model in told.models.items():
            error = MILLI * model.rms[shown, i]
            lines.append(of_joint(i + 1, trace(after[shown], error, NAMES[name], COLOURS[name])))
    title, label = "Error of axis {joint} after the start of a window", f"RMS error [m{unit}]"
    layout = {"xaxis": LOG, "yaxis": DECADES, "height": 300}
    return figure(title, "time since the start [s]", label, lines, **layout)


def _line(t: Array, values: Array, name: str, colour: str) -> dict[str, Any]:
    """Thinned window by window: a gap between two stays one."""
    every = max(1, len(t) // STRIP)
    kept = np.isnan(t) | (np.arange(len(t)) % every == 0)
    return trace(t[kept], values[kept], name, colour, points=2 * len(t))
