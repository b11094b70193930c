"""What was measured, as tables of rich."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.against import WORSE, Change, recorded
from benchmarks.clock import Row, Timing


def show(measured: dict[str, Any], console: Console) -> None:
    """Print whatever `collect` found."""
    at = measured["where"]
    console.print(f"{at['cpu']}, {at['cores']} cores, load {at['load']}; {at['compiler']}")
    if measured["rows"]:
        _rows(measured["rows"], console)
    if "changes" in measured:
        _changes(measured["changes"], console)
    if "growth" in measured:
        _growth(measured["growth"], console)
    if "profile" in measured:
        _profile(measured, console)


def quantity(value: float, faster: bool) -> str:
    """Time in microseconds, milliseconds or seconds, or a factor of real time."""
    if faster:
        return f"{value:.3g} x"
    unit, size = next((u, s) for u, s in (("s", 1e9), ("ms", 1e6), ("us", 0.0)) if value >= s)
    return f"{value / (size or 1e3):.3g} {unit}"


def _rows(rows: list[Row], console: Console) -> None:
    table = Table(title="one core; processor time; bursts in turn")
    for name in ("what", "median", "best", "ratio", "recorded", "required", "stretch", "met"):
        table.add_column(name, justify="left" if name == "what" else "right")
    before = recorded()
    for row in rows:
        for k, timing in enumerate(row.timings):
            kept = before.get(row.key) if k == 0 else None
            cells = _cells(row, timing, kept, first=k == 0)
            table.add_row(*cells, end_section=timing is row.timings[-1])
    console.print(table)
    for row in rows:
        for text in [*row.notes, *(f"{t.name}: {t.note}" for t in row.timings if t.note)]:
            console.print(f"{row.key}: {text}", highlight=False)


def _cells(row: Row, timing: Timing, kept: float | None, first: bool) -> list[str]:
    values = [quantity(value, row.faster) for value in (timing.median, timing.least)]
    if not first:
        return [f"  {timing.name}", *values, f"{row.ratio(timing):.3g}", "", "", "", ""]
    limits = [
        "" if limit is None else (">= " if row.faster else "<= ") + quantity(limit, row.faster)
        for limit in (row.required, row.stretch)
    ]
    met = "stretch" if row.met(row.stretch) else "yes" if row.met(row.required) else "no"
    was = "" if kept is None else quantity(kept, row.faster)
    return [f"[bold]{row.what}[/]", *values, "", was, *limits, met]


def _changes(changes: Sequence[Change], console: Console) -> None:
    title = f"side by side with the other revision; slower: more than {WORSE:.2f} times"
    table = Table(title=title)
    for name in ("what", "best before", "best now", "now / before, median", "slower"):
        table.add_column(name, justify="left" if name == "what" else "right")
    for one in changes:
        best = [quantity(value, False) for value in (one.before, one.now)]
        table.add_row(one.what, *best, f"{one.ratio:.3f}", "yes" if one.worse else "no")
    console.print(table)


def _growth(measured: dict[str, Any], console: Console) -> None:
    table = Table(title="growth")
    for name in ("parameters of K", "median", "ns for a square of a parameter"):
        table.add_column(name, justify="right")
    for timing in measured["parameters"]:
        each = timing.median / int(timing.name) ** 2
        table.add_row(timing.name, quantity(timing.median, False), f"{each:.2f}")
    console.print(table)
    names = (
        "loops in threads",
        "simulated s in 1 s of the clock",
        "in 1 s of processor time",
        "as a multiple of one on one core, by the clock",
    )
    table = Table(*names, title="side by side")
    loops = measured["loops"]
    first = next(iter(loops.values()))[0]
    for name, factors in loops.items():
        table.add_row(name, *(f"{factor:.3g}" for factor in (*factors, factors[0] / first)))
    for kind, gain in measured["cores"].items():
        table.add_row(f"plain C on 2 cores: {kind}", "", "", f"{gain:.3g}")
    console.print(table)


def _profile(measured: dict[str, Any], console: Console) -> None:
    table = Table("FMU", "us a step", "ms a simulated second", "share", title="where the time goes")
    total = sum(share for share, _ in measured["profile"].values())
    for name, (share, step) in measured["profile"].items():
        table.add_row(name, f"{step:.2f}", f"{share * 1e3:.2f}", f"{share / total:.0%}")
    console.print(table)
    table = Table("generated function", "operations", title="straight-line code")
    for functions in measured["operations"].values():
        for name, count in functions.items():
            table.add_row(name, str(count))
    console.print(table)
