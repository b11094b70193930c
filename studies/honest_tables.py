"""Tables of many outcomes: counts with n and Wilson intervals, coverage, calibration."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from results.shares import share
from studies.honest import CATEGORIES, FAINT, OBSERVABLE, Outcome

NAMED = ("right", "both")
FIFTHS = 5


@dataclass(frozen=True)
class Row:
    """An outcome of a category and size class: `hits` of `n`."""

    category: str
    size: str
    outcome: str
    hits: int
    n: int


def rows(outcomes: Sequence[Outcome]) -> list[Row]:
    """All outcomes that occurred, by category and size class, the most frequent first."""
    found = []
    for category in CATEGORIES:
        for size in ("observable", "fainter", ""):
            group = [o for o in outcomes if o.category == category and size_of(o) == size]
            counts = Counter(o.outcome for o in group).most_common()
            found += [Row(category, size, word, hits, len(group)) for word, hits in counts]
    return found


def size_of(outcome: Outcome) -> str:
    """observable, fainter, or nothing where no effect is hidden.

    Two effects are observable where both are; outside the library the limit is higher.
    """
    if not outcome.observable:
        return ""
    least = OBSERVABLE if outcome.category == "outside" else FAINT
    return "observable" if min(outcome.observable) >= least else "fainter"


def coverage(outcomes: Sequence[Outcome]) -> tuple[int, int]:
    """Intervals that hold the truth, and all that can be compared."""
    flat = [covered for o in outcomes for covered in o.covered.values()]
    return sum(flat), len(flat)


def calibration(outcomes: Sequence[Outcome]) -> list[tuple[float, int, int]]:
    """By fifths of the printed confidence: its mean, how many names were right, how many cases."""
    sure = [o for o in outcomes if o.confidence is not None and o.named]
    found = []
    for k in range(FIFTHS):
        low, high = k / FIFTHS, (k + 1) / FIFTHS
        group = [
            o
            for o in sure
            if o.confidence is not None
            and (low <= o.confidence < high or (k == FIFTHS - 1 and o.confidence >= 1.0))
        ]
        if group:
            mean = sum(o.confidence or 0.0 for o in group) / len(group)
            found.append((mean, sum(o.outcome in NAMED for o in group), len(group)))
    return found


def text(outcomes: Sequence[Outcome]) -> str:
    """The tables for a terminal or a page, in Markdown."""
    lines = ["| hidden | size | outcome | cases |", "| --- | --- | --- | --- |"]
    for row in rows(outcomes):
        lines.append(f"| {row.category} | {row.size} | {row.outcome} | {share(row.hits, row.n)} |")
    lines += ["", f"Intervals that hold the true value: {share(*coverage(outcomes))}."]
    listed = calibration(outcomes)
    if listed:
        lines += ["", "| confidence | right |", "| --- | --- |"]
        lines += [f"| {mean:.2f} | {share(hits, n)} |" for mean, hits, n in listed]
    return "\n".join(lines)
