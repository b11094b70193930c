"""Where the values of a machine file come from: counts of `source`, for the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexhex.fmus.common.machine.quantity import SOURCES
from flexhex.fmus.common.machine_file import machine_data

TUNED = "tuned"
"""Word in the note of an assumed value that was moved until the simulation fitted."""


def sources(machine_file: Path) -> dict[str, int]:
    """Quantities of the file by source, vectors and matrices as one; `tuned`: of the assumed."""
    counted = Counter(
        kind for quantity in _quantities(machine_data(machine_file)) for kind in _kinds(quantity)
    )
    return {kind: counted[kind] for kind in (*SOURCES, TUNED) if counted[kind]}


def sentence(machine_file: Path) -> str:
    """`Quantities in tflex.toml: 13 published, 11 derived, 48 assumed (7 of them tuned).`"""
    counts = sources(machine_file)
    tuned = counts.pop(TUNED, 0)
    listed = [f"{n} {kind}" for kind, n in counts.items()]
    if tuned:
        listed = [f"{t} ({tuned} of them tuned)" if t.endswith("assumed") else t for t in listed]
    return f"Quantities in {machine_file.name}: {', '.join(listed)}."


def _kinds(quantity: dict[str, Any]) -> Iterator[str]:
    yield quantity["source"]
    if quantity["source"] == "assumed" and TUNED in str(quantity.get("note", "")).split():
        yield TUNED


def _quantities(data: Any) -> Iterator[dict[str, Any]]:
    """All tables with a value and a source, however deep."""
    if isinstance(data, dict):
        if "value" in data and "source" in data:
            yield data
        else:
            for part in data.values():
                yield from _quantities(part)
    elif isinstance(data, list):
        for part in data:
            yield from _quantities(part)
