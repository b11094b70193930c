"""The moving pictures of the report: feedback only beside adaptive feedforward, and the residual
before and after what the model lacks was added."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexhex.compare.runs import Run
from flexhex.diagnosis.logs import read_log
from flexhex.diagnosis.verdict import Strip
from flexhex.output.plots import COLOURS
from flexhex.run.outcome import Outcome, PaperRun
from flexhex.ssp.result import Group, Result
from flexhex.tracking import ERROR, SETTLE
from flexhex.view.data import Size, page_data
from flexhex.view.page import view_html
from flexhex.view.sources import of_log

SECONDS = 4.0
"""Length of the clip [s]: about four moves."""
SIZE = Size(frames=1600, values=120_000)
FARTHEST = 0.2
"""Magnified error of the worse run at its largest [rad]: seen at once, and within the stroke."""
STEPS = 4
"""Steps of the magnification in a decade, as on the page."""


@dataclass(frozen=True)
class Clip:
    """The page, which stands in a frame of the report, and a sentence below it."""

    page: str
    text: str


def clip(run: PaperRun) -> Clip | None:
    """Both runs over the same seconds; None for a machine without a platform or without Table I."""
    machine = run.builder.machine
    if not run.table or not machine.has_platform or machine.n_arms != 6:
        return None
    shown = [_run(run.table.of("feedback")), _run(run.adaptive)]
    span = (SETTLE, min(SETTLE + SECONDS, *(one.result.duration for one in shown)))
    factor = _factor(shown, span)
    data = page_data(shown, machine, span, SIZE, ghost="beside", factor=factor)
    text = (
        f"The first {span[1] - span[0]:g} s of both runs with the error drawn {factor:.2g} times"
        " as large; press play, or hover over a plot. A larger “error ×” shows what adaptive"
        " feedforward leaves."
    )
    return Clip(view_html("feedback only beside adaptive feedforward", data), text)


def residual_clip(run: PaperRun) -> Clip | None:
    """A logged run twice, joints coloured by the residual: the model as it was, and extended.

    None where nothing was diagnosed or no effect was found.
    """
    missing = run.experiments.get("missing")
    if not missing or not missing.diagnosis.effects or not missing.diagnosis.strips:
        return None
    strips = missing.diagnosis.strips
    result = of_log(read_log(Path(strips[0].run)))
    runs = [
        Run(name, name, colour, _with_residual(result, strips, side))
        for name, colour, side in (
            ("original model", COLOURS["fixed"], "before"),
            ("extended model", COLOURS["adaptive"], "after"),
        )
    ]
    begin = max(SETTLE, float(strips[0].time[0]))
    span = (begin, min(begin + SECONDS, float(strips[0].time[-1])))
    data = page_data(runs, run.builder.machine, span, SIZE, ghost="beside", factor=1.0)
    text = (
        f"{span[1] - span[0]:g} s of a {'held-out' if strips[0].held_out else 'fitted'} run, joints"
        " coloured by the torque that the model leaves unexplained (the signal “residual”): left"
        " the original model, right the one with the effects that were found."
    )
    return Clip(view_html("residual before and after", data), text)


def _with_residual(result: Result, strips: Sequence[Strip], side: str) -> Result:
    """A log as a result, with the residual of one model at its samples."""
    group = result.group("theta")
    left = [
        np.interp(group.time, strip.time, np.nan_to_num(strip.measured - getattr(strip, side)))
        for strip in strips
    ]
    signals = {"theta": group.signals["theta"], "residual": np.column_stack(left)}
    units = {"theta": "rad", "residual": strips[0].unit}
    made = Group(group.period, group.base, signals, units)
    return Result({"log": made}, duration=result.duration)


def _run(outcome: Outcome) -> Run:
    case = outcome.case
    return Run(case.title, case.name, COLOURS[case.name], outcome.result)


def _factor(runs: list[Run], span: tuple[float, float]) -> float:
    """The largest step from 1 to 1000 that keeps the magnified errors within FARTHEST."""
    most = 1e-12
    for run in runs:
        time = run.result.time(ERROR)
        kept = (time >= span[0]) & (time <= span[1])
        most = max(most, float(np.abs(run.result[ERROR][kept]).max()))
    step = math.floor(STEPS * math.log10(FARTHEST / most))
    return float(10 ** (min(max(step, 0), 3 * STEPS) / STEPS))
