"""How a study is shown: table of medians and 5 / 95 % limits, box plots, JSON, progress bar."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from flexhex.output.page import Part, write_page
from flexhex.output.plots import COLOURS, LOG, Figure, figure
from flexhex.study.draws import CASES, VARIED, Found
from flexhex.study.store import Scored

Array = NDArray[np.float64]
LIMITS = (5.0, 25.0, 50.0, 75.0, 95.0)
"""Percentiles of a box: ends of its whiskers, of the box, and the median."""
TITLES = {"fixed": "fixed feedforward", "adaptive": "adaptive feedforward"}
HEADINGS = ("", "runs", "e [µrad]", "5 %", "95 %", "τ_FB [N m]", "5 %", "95 %")
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


def bar() -> Progress:
    """Runs done of all, time left; on stderr."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )


def summaries(found: Found) -> list[Summary]:
    """Each case that has a finished run."""
    listed = []
    for case in CASES:
        if runs := found.of(case):
            e, tau_fb = _percentiles([s.e for s in runs]), _percentiles([s.tau_fb for s in runs])
            listed.append(Summary(case, len(runs), sum(s.faults > 0 for s in runs), e, tau_fb))
    return listed


def print_found(found: Found, store: Path, page: Path) -> None:
    """The table, how the cases compare run by run, what failed, where everything is."""
    out = Console()
    title = "RMS of error and feedback torque, median and limits over the runs"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for k, name in enumerate(HEADINGS):
        table.add_column(name, justify="right" if k else "left", no_wrap=True)
    for row in rows(found):
        table.add_row(*row)
    out.print(table)
    for text in (*remarks(found), f"figures  {store}", f"page     {page}"):
        out.print(text, markup=False, highlight=False, soft_wrap=True)


def rows(found: Found) -> list[tuple[str, ...]]:
    """The table in the order of `HEADINGS`."""
    listed = []
    for s in summaries(found):
        e = [f"{s.e[k] * 1e6:.1f}" for k in (2, 0, 4)]
        tau_fb = [f"{s.tau_fb[k]:.4f}" for k in (2, 0, 4)]
        listed.append((TITLES[s.case], str(s.runs), *e, *tau_fb))
    return listed


def remarks(found: Found) -> list[str]:
    """What the table does not say, a line each."""
    said = [f"drawn anew for every run: {', '.join(found.plan.varied)}"]
    if pairs := found.pairs():
        better = sum(adaptive.e < fixed.e for fixed, adaptive in pairs)
        ratio = np.median([adaptive.e / fixed.e for fixed, adaptive in pairs if fixed.e > 0])
        said.append(
            f"adaptive has the smaller error in {better} of {len(pairs)} runs,"
            f" the median of adaptive / fixed is {ratio:.2f}"
        )
    said += [
        f"{s.faulty} runs with a fault: {TITLES[s.case]}" for s in summaries(found) if s.faulty
    ]
    failed = list(found.failed.values())
    said += [f"failed: {text}" for text in failed[:MOST_FAILED]]
    if len(failed) > MOST_FAILED:
        said.append(f"and {len(failed) - MOST_FAILED} more failed")
    if found.kept:
        said.append(f"{found.kept} of {len(found.tasks)} figures were there already")
    return said


def found_json(found: Found, store: Path, page: Path) -> str:
    """Everything for a program: percentiles by case, run by run, what failed."""
    data = {
        "plan": asdict(found.plan),
        "percentiles": LIMITS,
        "cases": {s.case: asdict(s) for s in summaries(found)},
        "runs": [asdict(s) for case in CASES for s in found.of(case)],
        "failed": list(found.failed.values()),
        "kept": found.kept,
        "store": str(store),
        "page": str(page),
    }
    return json.dumps(data, indent=2, allow_nan=False)


def write_found(found: Found, path: Path) -> Path:
    """The page: table, box plots, and the error over what was drawn."""
    plan = found.plan
    boxes = {
        "error": _boxes(found, "e", "Tracking error", "e [µrad]", 1e6),
        "torque": _boxes(found, "tau_fb", "Feedback torque", "τ_FB [N m]", 1.0),
    }
    over = {f"over-{n}": _over(found, n, text) for n, text in SHOWN.items() if n in plan.varied}
    text = (
        f"{plan.runs} draws, each {plan.duration:g} s after a hold, seed {plan.seed}. Box:"
        " quartiles and median; whiskers: 5 % and 95 %; dots: the runs. Both cases share the draws."
    )
    drawn = [(name, VARIED[name]) for name in plan.varied]
    parts = [
        Part("Error and feedback torque", text, HEADINGS, rows(found), boxes),
        Part("What was drawn", "", ("kind", "what"), drawn, over, words=True),
        Part("Remarks", "", ("",), [(text,) for text in remarks(found)], words=True),
    ]
    return write_page(path, "The loop on many machines", "Figures are RMS over all joints", parts)


def box(values: Sequence[float], x: float, name: str, colour: str) -> list[dict[str, object]]:
    """A box plot at x as lines and dots: plotly-basic has no boxes."""
    low, first, median, third, high = _percentiles(values)
    line = {"color": colour, "width": 1.5}
    # the gap of None lifts the pen
    whiskers_x = [x, x, None, x, x, None, x - 0.08, x + 0.08, None, x - 0.08, x + 0.08]
    whiskers_y = [low, first, None, third, high, None, low, low, None, high, high]
    left, right = x - 0.2, x + 0.2
    spread = x + 0.3 + 0.1 * np.modf(0.618034 * np.arange(len(values)))[0]
    quiet = {"showlegend": False, "hoverinfo": "skip"}
    return [
        {"x": whiskers_x, "y": whiskers_y, "mode": "lines", "line": line, **quiet},
        {
            "x": [left, right, right, left, left],
            "y": [first, first, third, third, first],
            "mode": "lines",
            "fill": "toself",
            "line": line,
            **quiet,
        },
        {"x": [left, right], "y": [median] * 2, "mode": "lines", "line": {**line, "width": 3}}
        | quiet,
        {
            "x": [round(float(v), 4) for v in spread],
            "y": [float(f"{v:.5g}") for v in values],
            "mode": "markers",
            "marker": {"color": colour, "size": 5, "opacity": 0.6},
            "name": name,
        },
    ]


def _boxes(found: Found, what: str, title: str, unit: str, scale: float) -> Figure:
    """Both cases side by side; logarithmic, since payloads spread the fixed case."""
    traces, cases = [], [case for case in CASES if found.of(case)]
    for k, case in enumerate(cases):
        values = [getattr(s, what) * scale for s in found.of(case)]
        traces += box(values, float(k), TITLES[case], COLOURS[case])
    axis = {
        "tickvals": list(range(len(cases))),
        "ticktext": [TITLES[case] for case in cases],
        "range": [-0.5, len(cases) - 0.4],
    }
    return figure(title, "", unit, traces, xaxis=axis, yaxis=LOG)


def _over(found: Found, name: str, text: str) -> Figure:
    """The error of every run over one of the numbers drawn for it."""
    traces = []
    for case in CASES:
        runs: list[Scored] = [s for s in found.of(case) if name in s.drawn]
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
