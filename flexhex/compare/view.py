"""How a comparison is shown: tracking and signals in the terminal, JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console, Group

from flexhex.compare.results import (
    EQUAL,
    ONLY_FIRST,
    ONLY_SECOND,
    OUT,
    UNLIKE,
    Comparison,
    Difference,
)
from flexhex.compare.runs import Figures, Run
from flexhex.output.tables import Column, console, table

MOST_ROWS = 20
"""Signals within tolerance that the terminal shows; the page shows all."""
MOST_WIDTH = 1000
DISPENSABLE = ("at [s]", "RMS", "rate", "out from [s]", "allowed")
"""Columns that a narrow terminal does without, in this order."""
NUMBERS = ("worst", "allowed", "relative", "at [s]", "RMS", "out from [s]")
HEADINGS = (
    "signal",
    "rate",
    "worst",
    "unit",
    "relative",
    "allowed",
    "at [s]",
    "RMS",
    "out from [s]",
    "",
)
"""worst: largest difference; relative: of the signal's largest value."""


def print_comparison(
    comparison: Comparison, judged: Figures | None, runs: Sequence[Run], page: Path | None
) -> None:
    """Tracking of both runs, signals, what differs in their making, verdict, where the page is."""
    out = Console(highlight=False)
    for run in runs:
        out.print(f"{run.name}: {run.file}", markup=False, soft_wrap=True)
    _print_tracking(judged, runs)
    near = [d for d in comparison.of(EQUAL) if d.worst > 0]
    shown = [*comparison.of(OUT, UNLIKE), *near[:MOST_ROWS]]
    if shown:
        out.print(_fitting(out, [cells(d) for d in shown]))
    same = len(comparison.of(EQUAL)) - len(near)
    if (left := len(near) - MOST_ROWS) > 0:
        out.print(f"and {left} signals within tolerance" + (" on the page" if page else ""))
    if same:
        out.print(f"{same} signals do not differ at all")
    for text in missing(comparison, runs):
        out.print(text, markup=False)
    if comparison.provenance:
        provenance = [
            (key, *(_short(key, text) for text in pair))
            for key, pair in comparison.provenance.items()
        ]
        headings = ("", *(run.name for run in runs))
        out.print(_table("How the runs were made: differences", headings, provenance))
    out.print(verdict(comparison), markup=False)
    if page:
        out.print(f"page     {page}", markup=False, soft_wrap=True)


def _print_tracking(judged: Figures | None, runs: Sequence[Run]) -> None:
    if judged is None:
        console().print("No tracking figures: feedback.e is not in both runs.\n", markup=False)
        return
    headings = figure_headings(runs)
    columns = [Column(str(k), heading, right=k > 0) for k, heading in enumerate(headings)]
    rows = [{str(k): cell for k, cell in enumerate(row)} for row in figure_rows(judged)]
    console().print(table(judged_text(judged), columns, rows))


def figure_headings(runs: Sequence[Run]) -> tuple[str, str, str, str]:
    """Headings of the tracking figures."""
    return ("", runs[0].name, runs[1].name, "ratio second / first")


def figure_rows(judged: Figures) -> list[tuple[str, ...]]:
    """The tracking figures of both runs and their ratio."""
    return [
        (
            f"{f.title} [{f.unit}]",
            f"{f.first:.4g}",
            f"{f.second:.4g}",
            f"{f.ratio:.3f}" if math.isfinite(f.ratio) else "–",
        )
        for f in judged.rows
    ]


def judged_text(judged: Figures) -> str:
    """What the figures are of."""
    return f"All joints, from {judged.begin:g} s to {judged.end:g} s."


def verdict(comparison: Comparison) -> str:
    """The result in one line."""
    judged, out = len(comparison.of(EQUAL, OUT)), len(comparison.of(OUT))
    text = f"{judged - out} of {judged} signals within tolerance, {out} differ"
    if unlike := len(comparison.of(UNLIKE)):
        text += f", {unlike} could not be compared"
    if alone := len(comparison.of(ONLY_FIRST, ONLY_SECOND)):
        text += f", {alone} in one run only"
    return f"{'equal' if comparison.equal else 'different'}: {text}"


def missing(comparison: Comparison, runs: Sequence[Run]) -> list[str]:
    """Signals of one run alone and a difference in duration, a line each."""
    lines = []
    for state, run in zip((ONLY_FIRST, ONLY_SECOND), runs, strict=True):
        if names := [d.signal for d in comparison.of(state)]:
            lines.append(f"only in {run.name}: {', '.join(names)}")
    a, b = comparison.durations
    if not math.isclose(a, b, rel_tol=1e-12):
        lines.append(f"durations {a:g} s and {b:g} s: compared over {min(a, b):g} s")
    return lines


def cells(d: Difference) -> tuple[str, ...]:
    """One row of the table, in the order of `HEADINGS`."""
    if d.state == UNLIKE:
        return (d.signal, d.rate, "", d.unit, *[""] * 5, f"{d.state}: {d.note}")
    name = d.column if d.element and d.worst > 0 else d.signal
    # 162 parameters have as many units: the table shows one
    unit = d.unit.split(",")[max(d.element, 1) - 1] if "," in d.unit else d.unit
    first = "" if math.isnan(d.first) else f"{d.first:.6g}"
    at = "" if d.worst == 0 else f"{d.at:.6g}"
    numbers = (f"{d.worst:.3g}", unit, f"{d.size:.2g}", f"{d.limit:.2g}", at, f"{d.rms:.3g}", first)
    return (name, d.rate, *numbers, "out" if d.state == OUT else "")


def comparison_json(
    comparison: Comparison, judged: Figures | None, runs: Sequence[Run], page: Path | None
) -> str:
    """Everything for a program; a figure that is no number is null."""
    data = {
        "equal": comparison.equal,
        "verdict": verdict(comparison),
        "runs": [{"name": run.name, "file": run.file} for run in runs],
        "tracking": _tracking_data(judged),
        "durations": comparison.durations,
        "signals": [{k: _finite(v) for k, v in asdict(d).items()} for d in comparison.differences],
        "provenance": {
            key: {"first": a, "second": b} for key, (a, b) in comparison.provenance.items()
        },
        "page": str(page) if page else None,
    }
    return json.dumps(data, indent=2, allow_nan=False)


def _tracking_data(judged: Figures | None) -> dict[str, Any] | None:
    if judged is None:
        return None
    figures = {
        f.key: {key: _finite(getattr(f, key)) for key in ("first", "second", "ratio")}
        for f in judged.rows
    }
    return {"from_s": judged.begin, "to_s": judged.end, **figures}


def _table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Group:
    fixed = (*NUMBERS, "signal", "rate", "unit")
    columns = []
    for k, name in enumerate(headings):
        words, _, unit = name.partition(" [")
        number, fold = name in NUMBERS, name not in fixed
        columns.append(Column(str(k), words, unit.rstrip("]"), right=number, fold=fold))
    return table(title, columns, [{str(k): c for k, c in enumerate(row)} for row in rows])


def _fitting(out: Console, rows: Sequence[Sequence[str]]) -> Group:
    """The table of the signals without the columns that the terminal has no width for."""
    for count in range(len(DISPENSABLE) + 1):
        keep = [k for k, name in enumerate(HEADINGS) if name not in DISPENSABLE[:count]]
        chosen = [[row[k] for k in keep] for row in rows]
        drawn = _table("Differences, largest first", [HEADINGS[k] for k in keep], chosen)
        wide = out.options.update(max_width=MOST_WIDTH)
        if out.measure(drawn, options=wide).maximum <= out.width:
            break
    return drawn


def _short(key: str, text: str) -> str:
    """A value as a terminal shows it: of a hash the beginning."""
    return text[:12] if key.startswith("sha256") else text


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
