"""The report: one HTML file with tables and plots that needs no network."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.cases import SETTLE
from flexhex.experiments import experiment, render
from flexhex.faults import study_faults
from flexhex.metrics import COLUMNS, PAPER, PAPER_ACTUATORS
from flexhex.plots import COLOURS, Figure, figure, moving_rms, spectrum, trace
from flexhex.run import Outcome, Study
from fmus.common.parameters import parameters

LOG = {"type": "log", "dtick": 1}


def write_report(study: Study, path: Path) -> Path:
    """Render the report of a study to `path`."""
    import jinja2

    assets = resources.files("flexhex") / "assets"
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string((assets / "report.html.j2").read_text(encoding="utf-8"))
    figures = _figures(study)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = template.render(
        study=study,
        machine=study.builder.machine,
        headings=COLUMNS,
        paper=PAPER,
        paper_actuators=PAPER_ACTUATORS,
        faults=study_faults(study),
        speed=_speed(study) if study.table else [],
        made=study.adaptive.made if study.table else study.fit_outcome.made,
        sections={name: render(name, result) for name, result in study.experiments.items()},
        figures=list(figures),
        figures_json=json.dumps(figures).replace("</", "<\\/"),
        plotly=(assets / "plotly-basic.min.js").read_text(encoding="utf-8"),
    )
    path.write_text(text, encoding="utf-8")
    return path


def _judged(outcome: Outcome, signal: str) -> tuple[Any, Any, float]:
    """Time after the settling time [s], samples, sample time [s] of a signal."""
    group = outcome.result.group(signal)
    keep = group.time > SETTLE
    t = np.asarray(group.time)[keep] - SETTLE
    return t, np.asarray(group.signals[signal])[keep], float(t[1] - t[0])


def _figures(study: Study) -> dict[str, Figure]:
    """Plots of the report by the id of the place where they stand."""
    found: dict[str, Figure] = {}
    if study.table:
        found = {
            "error": _error(study),
            "torque": _torque(study.adaptive),
            "spectrum": _spectrum(study),
            "joints": _joints(study.adaptive),
            "adapting": _parameters(study),
        }
    for name, result in study.experiments.items():
        found |= experiment(name).figures(result)
    return found


def _error(study: Study) -> Figure:
    lines = []
    for outcome in study.compared:
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
    title = f"Torque of actuator 1, {outcome.case.title} (as Fig. 5)"
    return figure(title, "time [s]", "torque [N m]", lines)


def _spectrum(study: Study) -> Figure:
    lines = []
    for outcome in study.compared:
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


def _parameters(study: Study) -> Figure:
    """Estimates of the adaptive run against the fit, in standard deviations' unit: the scale."""
    outcome, machine = study.adaptive, study.builder.machine
    listed = parameters(machine)
    t, p, _ = _judged(outcome, "K.p")
    scale = np.maximum(np.abs(study.fit.p), [par.floor for par in listed])
    moved = (p - study.fit.p) / scale
    most = np.argsort(-np.abs(moved).max(axis=0))[:8]
    lines = [trace(t, moved[:, k] * 100, listed[k].name) for k in most]
    title = "The eight parameters that adapt most, change relative to the fit"
    return figure(title, "time [s]", "change [%]", lines)


def _speed(study: Study) -> list[dict[str, Any]]:
    """Time spent in each FMU instance of the adaptive run."""
    outcome = study.adaptive
    rows = []
    for name, spent in outcome.result.times.items():
        rows.append(
            {
                "name": name,
                "steps": spent.steps,
                "mean_us": spent.seconds / max(spent.steps, 1) * 1e6,
                "share": spent.seconds / outcome.result.wall,
                "ms_per_s": spent.seconds / outcome.case.duration * 1e3,
            }
        )
    return rows
