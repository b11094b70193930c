"""The moving pictures at the top of the report: feedback only beside adaptive feedforward, a
payload that is bolted on and learnt, the residual before and after what the model lacks was added.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.compare.runs import Run
from flexhex.diagnosis.logs import read_log
from flexhex.diagnosis.result.pictured import Strip
from flexhex.experiments.payload import Payload
from flexhex.output.plots import COLOURS
from flexhex.run.outcome import Outcome, PaperRun
from flexhex.ssp.result import Array, Group, Result
from flexhex.tracking import ERROR, SETTLE
from flexhex.view.data import Size, page_data
from flexhex.view.page import json_text, view_html
from flexhex.view.sources import of_log

SECONDS = 4.0
"""Length of a clip [s]: about four moves."""
BEFORE, LEARNING = 1.0, 9.0
"""What is shown before a payload is bolted on, and of how it is learnt [s]."""
SIZE = Size(frames=800, values=50_000)
FARTHEST = 0.2
"""Magnified error of the worse run at its largest [rad]: seen at once, and within the stroke."""
LARGE = 1000.0
"""Magnification that shows what adaptive feedforward leaves; the page draws no joint further off
than the machine can show."""
STEPS = 4
"""Steps of the magnification in a decade, as on the page."""
PLACE = "@data@"
"""Where the data of a clip go in the page that all share."""


@dataclass(frozen=True)
class Clip:
    """What a button of the report calls it, the data of the page, a sentence below it."""

    title: str
    data: dict[str, Any]
    text: str


def clips(run: PaperRun) -> list[Clip]:
    """Those that the run has data for; none for a machine that is no hexapod."""
    machine = run.builder.machine
    if not machine.has_platform or machine.n_arms != 6:
        return []
    candidates = (_adaptive(run), _payload(run), _residual(run))
    return [clip for clip in candidates if clip]


def clips_json(shown: Sequence[Clip]) -> str:
    """For the script of the report: one page, and for each clip what goes into it."""
    page = view_html("clip", PLACE)
    listed = [{"title": c.title, "text": c.text, "data": json_text(c.data)} for c in shown]
    return json_text({"page": page, "place": json.dumps(PLACE), "clips": listed})


def _adaptive(run: PaperRun) -> Clip | None:
    """Feedback only and adaptive feedforward over the same seconds; None without Table I."""
    if not run.table:
        return None
    shown = [_run(run.table.of("feedback")), _run(run.adaptive)]
    span = (SETTLE, min(SETTLE + SECONDS, *(one.result.duration for one in shown)))
    text = (
        f"Both runs from {span[0]:g} s to {span[1]:g} s with the error drawn {LARGE:g} times as"
        " large: with feedback only as large as the machine can show it, as the name below says."
        " Green: where the machine should be. Press play, or hover over a plot."
    )
    worst = _worst(shown, span)[1]
    return _clip(run, "feedback only and adaptive", shown, span, LARGE, text, t=worst)


def _payload(run: PaperRun) -> Clip | None:
    """Fixed and adaptive feedforward while a payload is bolted on; None without the experiment."""
    payload: Payload | None = run.experiments.get("payload")
    if not payload or not payload.results:
        return None
    model = (np.zeros_like(payload.mass), payload.mass)
    shown = [
        Run(f"{name} feedforward", name, COLOURS[name], _with_mass(result, payload, mass))
        for name, result, mass in zip(("fixed", "adaptive"), payload.results, model, strict=True)
    ]
    at, mass = payload.times[1], payload.masses[1]
    begin = SETTLE + max(0.0, at - BEFORE)
    span = (begin, min(SETTLE + at + LEARNING, shown[0].result.duration))
    factor = _factor(shown, span)
    text = (
        f"A payload of {mass:g} kg is bolted on at {SETTLE + at:g} s; the error is drawn"
        f" {_shown(factor)} times as large. Adaptive feedforward learns the mass (plot “mass”: line"
        " true, dashes the model) and the error falls; fixed feedforward keeps the wrong mass."
    )
    plots = ["feedback.e", "mass"]
    return _clip(run, "a payload is learnt", shown, span, factor, text, plots=plots)


def _with_mass(result: Result, payload: Payload, model: Array) -> Result:
    """A run with the payload and what the model takes for it [kg]."""
    rate = result.group("K.p")
    mass = np.zeros((rate.rows, 2))
    mass[-len(payload.true) :] = np.column_stack([payload.true, model])
    groups = {
        name: dataclasses.replace(
            group, signals={k: v for k, v in group.signals.items() if not k.startswith("K.")}
        )
        for name, group in result.groups.items()
    }
    kept = {name: group for name, group in groups.items() if group.signals}
    texts = {"mass": "payload: true, and as the model has it"}
    names = {"mass": (".true", ".model")}
    added = Group(rate.period, rate.base, {"mass": mass}, {"mass": "kg"}, texts, names)
    return dataclasses.replace(result, groups={**kept, "mass": added})


def _residual(run: PaperRun) -> Clip | None:
    """A logged run twice, joints coloured by the residual: the model as it was, and extended.

    None where nothing was diagnosed or no effect was found.
    """
    missing = run.experiments.get("missing")
    if not missing or not missing.diagnosis.effects or not missing.diagnosis.strips:
        return None
    strips = missing.diagnosis.strips
    result = of_log(read_log(Path(strips[0].run)))
    shown = [
        Run(name, name, colour, _with_residual(result, strips, side))
        for name, colour, side in (
            ("original model", COLOURS["fixed"], "before"),
            ("extended model", COLOURS["adaptive"], "after"),
        )
    ]
    begin = max(SETTLE, float(strips[0].time[0]))
    span = (begin, min(begin + SECONDS, float(strips[0].time[-1])))
    text = (
        f"{span[1] - span[0]:g} s of a {'held-out' if strips[0].held_out else 'fitted'} run, joints"
        " coloured by the torque that the model leaves unexplained (the signal “residual”): left"
        " the original model, right the one with the effects that the diagnosis found."
    )
    return _clip(run, "what the diagnosis adds", shown, span, 1.0, text)


def _with_residual(result: Result, strips: Sequence[Strip], side: str) -> Result:
    """A log as a result, with the residual of one model at its samples."""
    group = result.group("theta")
    left = [
        np.interp(group.time, strip.time, np.nan_to_num(strip.measured - getattr(strip, side)))
        for strip in strips
    ]
    signals = {"theta": group.signals["theta"], "residual": np.column_stack(left)}
    units = {"theta": "rad", "residual": strips[0].unit}
    extended = Group(group.period, group.base, signals, units)
    return Result({"log": extended}, duration=result.duration)


def _clip(
    run: PaperRun,
    title: str,
    shown: list[Run],
    span: tuple[float, float],
    factor: float,
    text: str,
    **begins: Any,
) -> Clip:
    machine = run.builder.machine
    data = page_data(shown, machine, span, SIZE, ghost="beside", factor=factor, **begins)
    return Clip(title, data, text)


def _shown(factor: float) -> str:
    """Two digits, as the page has them: 56, 100."""
    return f"{float(f'{factor:.2g}'):g}"


def _run(outcome: Outcome) -> Run:
    case = outcome.case
    return Run(case.title, case.name, COLOURS[case.name], outcome.result)


def _factor(runs: list[Run], span: tuple[float, float]) -> float:
    """The largest step from 1 to 1000 that keeps the magnified errors within FARTHEST."""
    step = math.floor(STEPS * math.log10(FARTHEST / _worst(runs, span)[0]))
    return float(10 ** (min(max(step, 0), 3 * STEPS) / STEPS))


def _worst(runs: list[Run], span: tuple[float, float]) -> tuple[float, float]:
    """The largest error of a joint in the runs [rad], and when it is [s]."""
    peaks = [(1e-12, span[0])]
    for run in runs:
        time = run.result.time(ERROR)
        kept = (time >= span[0]) & (time <= span[1])
        size = np.abs(run.result[ERROR][kept]).max(axis=1)
        peaks.append((float(size.max()), float(time[kept][size.argmax()])))
    return max(peaks)
