"""The moving picture on top of the report: feedback only beside adaptive feedforward."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexhex.compare.runs import Run
from flexhex.output.plots import COLOURS
from flexhex.run.outcome import Outcome, PaperRun
from flexhex.tracking import ERROR, SETTLE
from flexhex.view.data import Size, page_data
from flexhex.view.page import view_html

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
