"""Single figures of the texts, by name: results file, how to find the figure in it, its format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flexhex.simulation.metrics import KEYS
from results import tables, times
from results.tables import Results

CORRECTION = "kinematics_correct"
EVERY = "*"
"""Stands for what `provenance` says in all results files."""


@dataclass(frozen=True)
class Source:
    """Where a figure or a table comes from: results file and what makes text of its `results`."""

    file: str
    text: Callable[[Results], str]


def number(form: str, *path: str | int) -> Callable[[Results], str]:
    """The number at a path of keys, in a format."""

    def text(results: Any) -> str:
        for key in path:
            results = results[key]
        return format(results, form)

    return text


def _missing(which: str) -> Source:
    path = ("experiments", "missing", "shown", "closed_loop", "machine", which, "e")
    return Source("missing", number(".1f", *path))


def _below(limit: float) -> Callable[[Results], str]:
    """How many machines of the showcase end below a tracking error [urad], of how many."""

    def text(lines: Results) -> str:
        ends = [n["shown"]["closed_loop"]["machine"]["after"]["e"] for n in lines if "shown" in n]
        return f"{sum(e < limit for e in ends)} of {len(lines)}"

    return text


def _deviation(results: Any) -> str:
    """The largest deviation of the feedback-only row from what is published [%]."""
    simulated, wanted = results["cases"]["feedback"], results["paper"]["feedback"]
    pairs = zip((simulated[key] for key in KEYS), wanted, strict=True)
    return f"{max(abs(value / paper - 1.0) for value, paper in pairs):.0%}".replace("%", " %")


FIGURES: dict[str, Source] = {
    "feedback deviation": Source("paper", _deviation),
    "schunk verdict": Source("schunk", number("", "verdict")),
    "missing before": _missing("before"),
    "missing after": _missing("after"),
    "feedback e": Source("paper", number(".0f", "cases", "feedback", "e")),
    "fixed e": Source("paper", number(".1f", "cases", "fixed", "e")),
    "adaptive e": Source("paper", number(".1f", "cases", "adaptive", "e")),
    "repeatability": Source("paper", number(".1f", "cases", "repeatability", "e")),
    "feedback dphi": Source("paper", number(".0f", "cases", "feedback", "dphi")),
    "feedback dx": Source("paper", number(".0f", "cases", "feedback", "dx")),
    "paper dphi": Source("paper", number(".0f", "paper", "feedback", 5)),
    "paper dx": Source("paper", number(".0f", "paper", "feedback", 2)),
    "operations of N": Source("speed", number("d", "operations", "kinematics", CORRECTION)),
    "machines below 10": Source("machines", _below(10.0)),
}
TABLES: dict[str, Source] = {
    "paper": Source("paper", tables.paper),
    "missing": Source("missing", tables.missing),
    "hidden": Source("hidden_effects", tables.hidden),
    "cases": Source("hidden_effects", tables.cases),
    "machines": Source("machines", tables.machines),
    "sensitivity": Source("sensitivity", tables.sensitivity),
    "speed": Source("speed", times.speed),
    "growth": Source("speed", times.growth),
    "loops": Source("speed", times.loops),
    "operations": Source("speed", times.operations),
    "schunk": Source("schunk", tables.schunk),
    "measured": Source("measured", tables.measured),
    "emps": Source("measured", tables.emps),
    "measured names": Source("measured", tables.measured_names),
    "measured payload": Source("measured", tables.measured_payload),
    "drive errors": Source("drive", times.drive_errors),
    "drive times": Source("drive", times.drive_times),
    "provenance": Source(EVERY, tables.provenance),
    "profile": Source("speed", times.profile),
    "quantisation": Source("quantisation", times.quantisation),
}
