"""`flexhex identify` of any base model but the hexapod: what it shows."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.diagnosis.estimation.excitation import Excitation
from flexhex.diagnosis.estimation.records import Errors, Identified, Parameter, summed
from flexhex.identify.view import signed, with_deviation

NARROWED = 10
"""Sums that are shown of what a motion would narrow."""
WIDE = 34
"""Characters of a sum that the terminal shows, so that its numbers stand beside it."""


def identified_json(
    found: Identified, written: Sequence[str] = (), more: Excitation | None = None
) -> str:
    """All of it as JSON; written: files; more: a motion and what it would narrow."""
    data = {**found.data(), "written": list(written)}
    if more is not None:
        data["next"] = [{"name": one.name, "narrower": share} for one, share in more.narrowed]
    return json.dumps(data, indent=2)


def print_excitation(more: Excitation) -> None:
    """What one more run is expected to narrow, the most of it."""
    out = Console()
    table = Table(title="One more run, along the motion written", box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("", no_wrap=True)
    table.add_column("± 95 % now", justify="right", no_wrap=True)
    table.add_column("then", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for one, share in more.narrowed[:NARROWED]:
        low, high = one.estimate.ci95
        wide = max(high - one.estimate.value, (high - low) / 2)
        name = short(one.terms).replace("[", r"\[")
        table.add_row(name, f"{wide:.2g}", f"{share * wide:.2g}", one.estimate.unit)
    out.print(table)
    say(out, "It stays within the positions, rates and accelerations of the logs. Collisions are"
        " not checked.")  # fmt: skip


def print_identified(found: Identified, every: bool = False) -> None:
    """Parameters, sums that the runs determine, errors. every: what they do not determine too."""
    out = Console()
    _print(out, "Parameters", found.parameters, every)
    single = {one.name for one in found.parameters}
    sums = [one for one in found.combinations if one.name not in single]
    if sums:
        _print(out, "Base parameters: sums that act as one", sums, every)
    hidden = [one for one in found.parameters if not one.determined]
    if hidden and not every:
        say(
            out,
            f"{len(hidden)} of {len(found.parameters)} parameters are not determined by these"
            " motions by themselves and stay near the file's values (--all shows them).",
        )
    if found.silent:
        say(out, f"No torque feels {_listed(found.silent)}.")
    low, high = found.delay.ci95
    if not low <= 0 <= high:
        way = "after" if found.delay.value > 0 else "before"
        late = f"{1e3 * abs(found.delay.value):.2g} ms {way} the angles"
        say(out, f"The torques stand {late} in the logs, or a friction of another form does.")
    _print_errors(out, found)
    for text in found.findings:
        say(out, f"finding: {text}")
    for text in found.notes:
        say(out, f"note: {text}")


def say(out: Console, text: str) -> None:
    """A plain line."""
    out.print(text, markup=False, highlight=False, soft_wrap=True)


def _print(out: Console, title: str, listed: Sequence[Parameter], every: bool) -> None:
    table = Table(title=title, box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("", no_wrap=True)
    table.add_column("estimate ± 95 %", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("file", justify="right", no_wrap=True)
    table.add_column("diff. / tol.", justify="right")
    shown = [one for one in listed if every or one.determined]
    for one in shown:
        name = (one.name if every else short(one.terms)).replace("[", r"\[")
        wide = (one.estimate.ci95[1] - one.estimate.ci95[0]) / 2
        open_end = max(one.estimate.ci95[1] - one.estimate.value, wide)
        file = "" if math.isinf(one.tolerance) and one.file == 0 else f"{one.file:.4g}"
        value = with_deviation(one.estimate.value, open_end)
        if not math.isfinite(open_end):
            value = "any"
        cells = (name + ("" if one.determined else " *"), value, one.estimate.unit, file)
        shift = signed(one.shift) if math.isfinite(one.shift) else ""
        table.add_row(*cells, shift, style=None if one.determined else "yellow")
    if shown:
        out.print(table)
    if any(not one.determined for one in shown):
        say(out, "* not determined by these motions by itself")


def short(terms: Sequence[tuple[str, float]]) -> str:
    """A sum with as many of its terms as fit."""
    texts = [summed(terms, most or None) for most in range(1, len(terms) + 1)]
    return max((t for t in (*texts, summed(terms)) if len(t) <= WIDE), key=len, default=texts[0])


def _print_errors(out: Console, found: Identified) -> None:
    table = Table(title="Share of the torque that is left (RMS)", box=SIMPLE_HEAD, pad_edge=False)
    both: list[tuple[str, Errors]] = [("runs", found.errors)]
    if found.held_out is not None:
        both.append(("held out", found.held_out))
    table.add_column("axis")
    table.add_column("torque RMS", justify="right", no_wrap=True)
    for name, _ in both:
        table.add_column(f"{name}: file", justify="right", no_wrap=True)
        table.add_column("identified", justify="right", no_wrap=True)
    for i, unit in enumerate(found.units):
        cells = [f"{100 * v:.3g} %" for _, e in both for v in (e.file[i], e.fitted[i])]
        table.add_row(str(i + 1), f"{found.errors.torque[i]:.3g} {unit}", *cells)
    out.print(table)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 2 else f"{', '.join(names[:-1])} or {names[-1]}"
