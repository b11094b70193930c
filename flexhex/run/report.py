"""The report: one HTML file with tables and plots that needs no network."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.experiments import experiment, render
from flexhex.fmus.common.model.parameters import parameters
from flexhex.output.page import plotly_js
from flexhex.output.plots import COLOURS, Figure, figure, moving_rms, spectrum, trace
from flexhex.output.tables import Column, html
from flexhex.run import loop
from flexhex.run.clip import clip
from flexhex.run.outcome import Outcome, PaperRun, figure_rows
from flexhex.run.view import (
    ACTUATOR_COLUMNS,
    TABLE_COLUMNS,
    VARIANT_COLUMNS,
    beside,
    model_sentence,
    variant_rows,
)
from flexhex.simulation.cases import SETTLE
from flexhex.simulation.provenance import sentence

LOG = {"type": "log", "dtick": 1}
SPEED_COLUMNS = (
    Column("name", "FMU"),
    Column("steps", "steps", number="d"),
    Column("mean_us", "a step", "µs", ".2f"),
    Column("ms_per_s", "per simulated s", "ms", ".2f"),
    Column("share", "share", "%", ".0f"),
)


def write_report(run: PaperRun, path: Path) -> Path:
    """Render the report of a run to `path`."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string(
        (resources.files(__package__) / "report.html.j2").read_text(encoding="utf-8")
    )
    figures = _figures(run)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = template.render(
        run=run,
        machine=run.builder.machine,
        tables=_tables(run),
        clip=clip(run),
        model_sentence=model_sentence(run) if run.is_model else "",
        beside=beside(run.table),
        sources=sentence(run.builder.machine_file),
        margins=html(loop.COLUMNS, [vars(loop.margins(run.builder.machine))]),
        faults=run.faults,
        provenance=(run.adaptive if run.table else run.fit_outcome).provenance,
        sections={name: render(name, result) for name, result in run.experiments.items()},
        figures=list(figures),
        figures_json=json.dumps(figures).replace("</", "<\\/"),
        plotly=plotly_js(),
    )
    path.write_text(text, encoding="utf-8")
    return path


def _tables(run: PaperRun) -> dict[str, Any]:
    """Tables of the report as HTML; those of Table I where it was simulated."""
    if not run.table:
        return {}
    return {
        "table": html(TABLE_COLUMNS, figure_rows(run.table)),
        "actuators": html(ACTUATOR_COLUMNS, figure_rows(run.actuators)),
        "variants": html(VARIANT_COLUMNS, variant_rows(run)),
        "speed": html(SPEED_COLUMNS, _speed(run)),
    }


def _judged(outcome: Outcome, signal: str) -> tuple[Any, Any, float]:
    """Time after the settling time [s], samples, sample time [s] of a signal."""
    group = outcome.result.group(signal)
    keep = group.time > SETTLE
    t = np.asarray(group.time)[keep] - SETTLE
    return t, np.asarray(group.signals[signal])[keep], float(t[1] - t[0])


def _figures(run: PaperRun) -> dict[str, Figure]:
    """Plots of the report by the id of the place where they stand."""
    drawn: dict[str, Figure] = {"bode": loop.bode(run.builder.machine)}
    if run.table:
        drawn |= {
            "error": _error(run),
            "torque": _torque(run.adaptive),
            "spectrum": _spectrum(run),
            "joints": _joints(run.adaptive),
            "adapting": _parameters(run),
        }
    for name, result in run.experiments.items():
        drawn |= experiment(name).figures(result)
    return drawn


def _error(run: PaperRun) -> Figure:
    lines = []
    for outcome in run.compared:
        t, e, ts = _judged(outcome, "feedback.e")
        colour = COLOURS[outcome.case.name]
        lines.append(trace(t, moving_rms(e, ts) * 1e6, outcome.case.title, colour))
    title = "Tracking error, RMS over the joints in a 0.25 s window"
    return figure(title, "time [s]", "e [µrad]", lines, yaxis=LOG)


def _torque(outcome: Outcome) -> Figure:
    t, tau, _ = _judged(outcome, "feedback.tau")
    _, fb, _ = _judged(outcome, "feedback.tau_fb")
    _, ff, _ = _judged(outcome, "F.tau_ff")
    ff = np.repeat(ff, max(1, round(len(tau) / len(ff))), axis=0)[: len(tau)]
    keep = t < 10
    lines = [
        # beneath the feedforward, which is nearly all of it
        trace(t[keep], tau[keep, 0], "total", "#9dc3e6"),
        trace(t[keep][: len(ff)], ff[keep[: len(ff)], 0][: keep.sum()], "feedforward", "#1b1b1b"),
        trace(t[keep], fb[keep, 0] * 10, "feedback × 10", "#c33"),
    ]
    lines[0]["line"]["width"], lines[1]["line"]["dash"] = 5, "dot"
    title = f"Torque of actuator 1, {outcome.case.title}"
    return figure(title, "time [s]", "torque [N m]", lines)


def _spectrum(run: PaperRun) -> Figure:
    lines = []
    for outcome in run.compared:
        _, e, ts = _judged(outcome, "feedback.e")
        f, density = spectrum(e * 1e6, ts)
        keep = f < 300
        lines.append(trace(f[keep], density[keep], outcome.case.title, COLOURS[outcome.case.name]))
    unit = "e [µrad/√Hz]"
    return figure("Spectrum of the error", "frequency [Hz]", unit, lines, xaxis=LOG, yaxis=LOG)


def _joints(outcome: Outcome) -> Figure:
    t, e, _ = _judged(outcome, "feedback.e")
    lines = [trace(t, e[:, i] * 1e6, f"joint {i + 1}") for i in range(e.shape[1])]
    return figure(f"Error of each joint, {outcome.case.title}", "time [s]", "e [µrad]", lines)


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
    return figure(title, "time [s]", "change [%]", lines)


def _speed(run: PaperRun) -> list[dict[str, Any]]:
    """Time spent in each FMU instance of the adaptive run."""
    outcome = run.adaptive
    rows = []
    for name, spent in outcome.result.times.items():
        rows.append(
            {
                "name": name,
                "steps": spent.steps,
                "mean_us": spent.seconds / max(spent.steps, 1) * 1e6,
                "share": 100 * spent.seconds / outcome.result.wall,
                "ms_per_s": spent.seconds / outcome.case.duration * 1e3,
            }
        )
    return rows
