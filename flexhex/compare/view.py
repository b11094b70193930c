"""How a comparison is shown: table in the terminal, JSON, page with overlays and differences."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from flexhex.compare.results import (
    EQUAL,
    ONLY_FIRST,
    ONLY_SECOND,
    OUT,
    UNLIKE,
    Array,
    Comparison,
    Difference,
    columns,
)
from flexhex.output.page import Part, write_page
from flexhex.output.plots import Figure, figure, trace
from flexhex.ssp.results import Result

MOST_ROWS = 20
"""Signals within tolerance that the terminal shows; the page shows all."""
FIRST, SECOND, GAP, LIMIT = "#1f6fb2", "#d1731d", "#444", "#c33"
MOST_WIDTH = 1000
DISPENSABLE = ("at [s]", "RMS", "rate", "out from [s]", "allowed")
"""Columns that a narrow terminal does without, the first of them always."""
HEADINGS = ("signal", "rate", "worst", "unit", "allowed", "at [s]", "RMS", "out from [s]", "")


def print_comparison(found: Comparison, page: Path | None) -> None:
    """Verdict, table of the signals, what made the runs different, where the page is."""
    out = Console()
    near = [d for d in found.of(EQUAL) if d.worst > 0]
    shown = [*found.of(OUT, UNLIKE), *near[:MOST_ROWS]]
    if shown:
        out.print(_fitting(out, [cells(d) for d in shown]))
    same = len(found.of(EQUAL)) - len(near)
    if (left := len(near) - MOST_ROWS) > 0:
        out.print(f"and {left} signals within tolerance" + (" on the page" if page else ""))
    if same:
        out.print(f"{same} signals do not differ at all")
    for text in missing(found):
        out.print(text, markup=False, highlight=False)
    if found.made:
        made = [(key, *(_short(key, text) for text in pair)) for key, pair in found.made.items()]
        out.print(_table("What made them different", ("", "first", "second"), made))
    out.print(verdict(found), markup=False, highlight=False)
    if page:
        out.print(f"page     {page}", markup=False, highlight=False, soft_wrap=True)


def verdict(found: Comparison) -> str:
    """The result in one line."""
    judged, out = len(found.of(EQUAL, OUT)), len(found.of(OUT))
    text = f"{judged - out} of {judged} signals within tolerance"
    if unlike := len(found.of(UNLIKE)):
        text += f", {unlike} could not be compared"
    if alone := len(found.of(ONLY_FIRST, ONLY_SECOND)):
        text += f", {alone} in one run only"
    return f"{'equal' if found.equal else 'different'}: {text}"


def missing(found: Comparison) -> list[str]:
    """Signals of one run alone and a difference in duration, a line each."""
    lines = []
    for state in (ONLY_FIRST, ONLY_SECOND):
        if names := [d.signal for d in found.of(state)]:
            lines.append(f"{state}: {', '.join(names)}")
    a, b = found.durations
    if not math.isclose(a, b, rel_tol=1e-12):
        lines.append(f"durations {a:g} s and {b:g} s: compared over {min(a, b):g} s")
    return lines


def cells(d: Difference) -> tuple[str, ...]:
    """One row of the table, in the order of `HEADINGS`."""
    if d.state == UNLIKE:
        return (d.signal, d.rate, "", d.unit, "", "", "", "", f"{d.state}: {d.note}")
    name = f"{d.signal}[{d.element}]" if d.element and d.worst > 0 else d.signal
    # 162 parameters have as many units: the table shows one
    unit = d.unit.split(",")[max(d.element, 1) - 1] if "," in d.unit else d.unit
    first = "" if math.isnan(d.first) else f"{d.first:.6g}"
    at = "" if d.worst == 0 else f"{d.at:.6g}"
    numbers = (f"{d.worst:.3g}", unit, f"{d.limit:.2g}", at, f"{d.rms:.3g}", first)
    return (name, d.rate, *numbers, "out" if d.state == OUT else "")


def comparison_json(found: Comparison, page: Path | None) -> str:
    """Everything for a program; a figure that is no number is null."""
    data = {
        "equal": found.equal,
        "verdict": verdict(found),
        "durations": found.durations,
        "signals": [
            {k: _finite(v) for k, v in asdict(d).items() if k != "size"} for d in found.differences
        ],
        "made": {key: {"first": a, "second": b} for key, (a, b) in found.made.items()},
        "page": str(page) if page else None,
    }
    return json.dumps(data, indent=2, allow_nan=False)


def write_comparison(
    found: Comparison, first: Result, second: Result, names: Sequence[str], plots: int, path: Path
) -> Path:
    """The page: overlay and difference of the `plots` signals that differ most, all figures."""
    chosen = [d for d in found.of(OUT, EQUAL) if d.worst > 0][:plots]
    parts = [Part(verdict(found), text=" · ".join(missing(found)))]
    for k, d in enumerate(chosen):
        overlay, gap = _plots(d, first, second)
        drawn = {f"overlay{k}": overlay, f"difference{k}": gap}
        parts.append(Part(d.signal, text=_sentence(d), figures=drawn, timed=True))
    if not chosen:
        parts.append(Part("No plots", text="No signal differs at all."))
    rows = [cells(d) for d in found.of(OUT, UNLIKE, EQUAL)]
    parts.append(Part("All signals", headings=HEADINGS, rows=rows))
    made = [(key, *pair) for key, pair in found.made.items()]
    text = "" if made else "Nothing: the same versions, hashes and parameters."
    headings = ("", "first", "second")
    parts.append(Part("What made them different", text, headings, made, words=True))
    return write_page(path, "Two runs compared", f"first: {names[0]}, second: {names[1]}", parts)


def _plots(d: Difference, first: Result, second: Result) -> tuple[Figure, Figure]:
    """The worst element of a signal in both runs, and second minus first with its tolerance."""
    (t, x), (s, y) = _element(d, first), _element(d, second)
    n = min(len(x), len(y))
    name, unit = cells(d)[0], f"[{cells(d)[3]}]"
    lines = [trace(t, x, "first", FIRST), trace(s, y, "second", SECOND)]
    overlay = figure(name, "time [s]", unit, lines)
    with np.errstate(invalid="ignore"):
        gap = y[:n] - x[:n]
    ends = np.array([t[0], t[n - 1]])
    lines = [trace(t[:n], gap, "second - first", GAP)]
    for sign, label in ((1, "tolerance"), (-1, "")):
        limit = np.full(2, sign * d.limit)
        lines.append(trace(ends, limit, label, LIMIT, showlegend=bool(label)))
    return overlay, figure(f"{name}, difference", "time [s]", unit, lines)


def _element(d: Difference, result: Result) -> tuple[Array, Array]:
    return result.time(d.signal), columns(result[d.signal])[:, max(d.element, 1) - 1]


def _sentence(d: Difference) -> str:
    _, _, worst, unit, limit, at, rms, first, _ = cells(d)
    said = f", out of tolerance from {first} s on" if first else ""
    return f"Worst {worst} {unit} at {at} s, allowed {limit}, RMS {rms}{said}."


def _table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    numbers = ("worst", "allowed", "at [s]", "RMS", "out from [s]")
    for name in headings:
        right, fixed = name in numbers, name in (*numbers, "signal", "rate", "unit")
        shown = name.replace(" [s]", "\n\\[s]")
        table.add_column(
            shown, justify="right" if right else "left", overflow="fold", no_wrap=fixed
        )
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    return table


def _fitting(out: Console, rows: Sequence[Sequence[str]]) -> Table:
    """The table of the signals without the columns that the terminal has no room for."""
    for count in range(1, len(DISPENSABLE) + 1):
        keep = [k for k, name in enumerate(HEADINGS) if name not in DISPENSABLE[:count]]
        chosen = [[row[k] for k in keep] for row in rows]
        table = _table("Differences, worst first", [HEADINGS[k] for k in keep], chosen)
        room = out.options.update(max_width=MOST_WIDTH)
        if out.measure(table, options=room).maximum <= out.width:
            break
    return table


def _short(key: str, text: str) -> str:
    """A value as a terminal shows it: of a hash the beginning."""
    return text[:12] if key.startswith("sha256") else text


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
