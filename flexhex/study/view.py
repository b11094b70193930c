"""How a study is shown: table of medians and 5 / 95 % limits, box plots, JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import COLOURS, LOG, Figure, figure
from flexhex.output.tables import Column, console, table, texts
from flexhex.study.draws import VARIED
from flexhex.study.store import Scored
from flexhex.study.tasks import CASES, StudyResult

Array = NDArray[np.float64]
LIMITS = (5.0, 25.0, 50.0, 75.0, 95.0)
"""Percentiles of a box: ends of its whiskers, of the box, and the median."""
ENDS = {"": 2, "_low": 0, "_high": 4}
"""Places of median, 5 % and 95 % among them, by the ending of their column."""
TITLES = {"fixed": "fixed feedforward", "adaptive": "adaptive feedforward"}
COLUMNS = (
    Column("case", ""),
    Column("runs", "runs", number="d"),
    Column("e", "e, median", "µrad", ".1f"),
    Column("e_low", "5 %", "µrad", ".1f"),
    Column("e_high", "95 %", "µrad", ".1f"),
    Column("tau_fb", "τ_FB, median", "N m", ".4f"),
    Column("tau_fb_low", "5 %", "N m", ".4f"),
    Column("tau_fb_high", "95 %", "N m", ".4f"),
)
SHOWN = {"payload": "payload [kg]", "age": "time since switched on [s]"}
"""Draws that the error is plotted over."""
MOST_FAILED = 10


@dataclass(frozen=True)
class Summary:
    """Percentiles (`LIMITS`) of one case: e [rad], tau_fb [N m]; runs, runs with a fault."""

    case: str
    runs: int
    faulty: int
    e: tuple[float, ...]
    tau_fb: tuple[float, ...]


def summaries(result: StudyResult) -> list[Summary]:
    """Each case that has a finished run."""
    listed = []
    for case in CASES:
        if runs := result.of(case):
            e, tau_fb = _percentiles([s.e for s in runs]), _percentiles([s.tau_fb for s in runs])
            listed.append(Summary(case, len(runs), sum(s.faults > 0 for s in runs), e, tau_fb))
    return listed


def print_result(result: StudyResult, store: Path, page: Path) -> None:
    """The table, how the cases compare run by run, what failed, where everything is."""
    out = console()
    out.print(table("RMS of error and feedback torque over the runs", COLUMNS, rows(result)))
    for text in (*remarks(result), f"figures  {store}", f"page     {page}"):
        out.print(text, markup=False)


def rows(result: StudyResult) -> list[dict[str, str | float | None]]:
    """One row a case: medians and limits of its runs."""
    listed: list[dict[str, str | float | None]] = []
    for s in summaries(result):
        e = {f"e{end}": 1e6 * s.e[k] for end, k in ENDS.items()}
        tau_fb = {f"tau_fb{end}": s.tau_fb[k] for end, k in ENDS.items()}
        listed.append({"case": TITLES[s.case], "runs": s.runs, **e, **tau_fb})
    return listed


def remarks(result: StudyResult) -> list[str]:
    """What the table does not say, a line each."""
    lines = [f"drawn for every run: {', '.join(result.plan.varied)}"]
    if pairs := result.pairs():
        better = sum(adaptive.e < fixed.e for fixed, adaptive in pairs)
        ratio = np.median([adaptive.e / fixed.e for fixed, adaptive in pairs if fixed.e > 0])
        lines.append(
            f"adaptive has the smaller error in {better} of {len(pairs)} runs,"
            f" the median of adaptive / fixed is {ratio:.2f}"
        )
    lines += [
        f"{s.faulty} runs with a fault: {TITLES[s.case]}" for s in summaries(result) if s.faulty
    ]
    failed = list(result.failed.values())
    lines += [f"failed: {text}" for text in failed[:MOST_FAILED]]
    if len(failed) > MOST_FAILED:
        lines.append(f"and {len(failed) - MOST_FAILED} more failed")
    if result.kept:
        lines.append(f"{result.kept} of {len(result.tasks)} figures were computed before")
    return lines


def result_json(result: StudyResult, store: Path, page: Path) -> str:
    """Everything for a program: percentiles by case, run by run, what failed."""
    data = {
        "plan": asdict(result.plan),
        "percentiles": LIMITS,
        "cases": {s.case: asdict(s) for s in summaries(result)},
        "runs": [asdict(s) for case in CASES for s in result.of(case)],
        "failed": list(result.failed.values()),
        "kept": result.kept,
        "store": str(store),
        "page": str(page),
    }
    return json.dumps(data, indent=2, allow_nan=False)


def write_result(result: StudyResult, path: Path) -> Path:
    """The page: table, box plots, and the error over what was drawn."""
    plan = result.plan
    boxes = {
        "error": _boxes(result, "e", "Tracking error", "e [µrad]", 1e6),
        "torque": _boxes(result, "tau_fb", "Feedback torque", "τ_FB [N m]", 1.0),
    }
    over = {f"over-{n}": _over(result, n, text) for n, text in SHOWN.items() if n in plan.varied}
    text = (
        f"{plan.runs} draws, each {plan.duration:g} s after a hold, seed {plan.seed}. Box:"
        " quartiles and median; whiskers: 5 % and 95 %; dots: the runs. Both cases share the draws."
    )
    drawn = [(name, VARIED[name]) for name in plan.varied]
    parts = [
        PageSection("Error and feedback torque", text, *texts(COLUMNS, rows(result)), boxes),
        PageSection("Random quantities", "", ("kind", "what"), drawn, over, words=True),
        PageSection("Remarks", "", ("",), [(text,) for text in remarks(result)], words=True),
    ]
    return write_page(
        path, f"Study of {len(result.tasks)} runs", "Figures are RMS over all joints", parts
    )


def box(values: Sequence[float], x: float, name: str, colour: str) -> list[dict[str, object]]:
    """A box plot at x as lines and dots: plotly-basic has no boxes."""
    low, first, median, third, high = _percentiles(values)
    line = {"color": colour, "width": 1.5}
    # None interrupts the line
    whiskers_x = [x, x, None, x, x, None, x - 0.08, x + 0.08, None, x - 0.08, x + 0.08]
    whiskers_y = [low, first, None, third, high, None, low, low, None, high, high]
    left, right = x - 0.2, x + 0.2
    spread = x + 0.3 + 0.1 * np.modf(0.618034 * np.arange(len(values)))[0]
    hidden = {"showlegend": False, "hoverinfo": "skip"}
    return [
        {"x": whiskers_x, "y": whiskers_y, "mode": "lines", "line": line, **hidden},
        {
            "x": [left, right, right, left, left],
            "y": [first, first, third, third, first],
            "mode": "lines",
            "fill": "toself",
            "line": line,
            **hidden,
        },
        {"x": [left, right], "y": [median] * 2, "mode": "lines", "line": {**line, "width": 3}}
        | hidden,
        {
            "x": [round(float(v), 4) for v in spread],
            "y": [float(f"{v:.5g}") for v in values],
            "mode": "markers",
            "marker": {"color": colour, "size": 5, "opacity": 0.6},
            "name": name,
        },
    ]


def _boxes(result: StudyResult, what: str, title: str, unit: str, scale: float) -> Figure:
    """Both cases side by side; logarithmic, since payloads spread the fixed case."""
    traces, cases = [], [case for case in CASES if result.of(case)]
    for k, case in enumerate(cases):
        values = [getattr(s, what) * scale for s in result.of(case)]
        traces += box(values, float(k), TITLES[case], COLOURS[case])
    axis = {
        "tickvals": list(range(len(cases))),
        "ticktext": [TITLES[case] for case in cases],
        "range": [-0.5, len(cases) - 0.4],
    }
    return figure(title, "", unit, traces, xaxis=axis, yaxis=LOG)


def _over(result: StudyResult, name: str, text: str) -> Figure:
    """The error of every run over one of the numbers drawn for it."""
    traces = []
    for case in CASES:
        runs: list[Scored] = [s for s in result.of(case) if name in s.drawn]
        traces.append(
            {
                "x": [float(f"{s.drawn[name]:.5g}") for s in runs],
                "y": [float(f"{s.e * 1e6:.5g}") for s in runs],
                "mode": "markers",
                "marker": {"color": COLOURS[case], "size": 6, "opacity": 0.7},
                "name": TITLES[case],
            }
        )
    return figure(f"Error over {text.split(' [')[0]}", text, "e [µrad]", traces, yaxis=LOG)


def _percentiles(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(float(v) for v in np.percentile(values, LIMITS))
