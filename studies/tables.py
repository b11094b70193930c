"""What many scores say together: shares with Wilson intervals, confusion, detection, gaps."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from statistics import median

from studies.score import Score

SEEN = 0.004
"""Effects of which at least this share of torque RMS is observable have to be found."""
BINS = (0.0, 0.001, 0.002, 0.004, 0.006, 0.01, 0.02, 1.0)


def wilson(hits: int, n: int) -> tuple[float, float]:
    """95 % interval of a share; 0 to 1 where nothing was tried."""
    if n == 0:
        return 0.0, 1.0
    z, p = 1.959964, hits / n
    middle, width = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    low, high = (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)
    return max(0.0, min(low, p)), min(1.0, max(high, p))


def share(hits: int, n: int) -> str:
    """12/40 = 30.0 % (18.1 to 45.4)."""
    if n == 0:
        return "no case"
    low, high = wilson(hits, n)
    return f"{hits}/{n} = {100 * hits / n:.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def _count(scores: Iterable[Score], *outcomes: str) -> tuple[int, int]:
    listed = list(scores)
    return sum(s.outcome in outcomes for s in listed), len(listed)


def targets(scores: Sequence[Score]) -> list[tuple[str, str, str]]:
    """Claim, what is wanted, what was found with n and interval."""
    of = {c: [s for s in scores if s.category == c] for c in {s.category for s in scores}}
    nothing, single = of.get("nothing", []), of.get("single", [])
    seen = [s for s in single if s.observable[0] >= SEEN]
    faint = [s for s in single if s.observable[0] < SEEN]
    pairs = [s for s in of.get("pair", []) if min(s.observable) >= SEEN]
    rows = [
        ("nothing hidden: an effect named", "<= 1 %", share(*_count(nothing, "false_alarm"))),
        ("nothing hidden: unknown", "", share(*_count(nothing, "unknown"))),
        ("seen: alone or in a set of three", ">= 95 %", share(*_count(seen, "alone", "set"))),
        ("seen: named alone", ">= 80 %", share(*_count(seen, "alone"))),
        ("seen: joints exactly right", "", share(sum(bool(s.axes_right) for s in seen), len(seen))),
        ("seen: wrong", "<= 2 %", share(*_count(seen, "wrong"))),
        ("seen: missed", "", share(*_count(seen, "missed"))),
        ("faint: alone or in a set", "", share(*_count(faint, "alone", "set"))),
        ("faint: wrong", "<= 2 %", share(*_count(faint, "wrong"))),
        ("outside: unknown or none", ">= 95 %", share(*_count(of.get("outside", []), "right"))),
        ("pairs, both seen: both", ">= 80 %", share(*_count(pairs, "both"))),
        ("all pairs: both", "", share(*_count(of.get("pair", []), "both"))),
        ("all pairs: wrong", "<= 2 %", share(*_count(of.get("pair", []), "wrong"))),
        ("changed parameter: right", "", share(*_count(of.get("changed", []), "right"))),
        ("changed parameter: wrong", "", share(*_count(of.get("changed", []), "wrong"))),
        (
            "machines: all effects found",
            "",
            share(*_count(of.get("machine", []), "alone", "set", "both", "right")),
        ),
        ("machines: wrong", "", share(*_count(of.get("machine", []), "wrong"))),
    ]
    return rows


def confusion(scores: Sequence[Score]) -> tuple[list[str], list[tuple[str, list[int]]]]:
    """Columns and rows: truth down, what was said across (first name, or the verdict)."""
    counts: Counter[tuple[str, str]] = Counter()
    for s in scores:
        if len(s.truth) < 2:
            counts[_row(s), s.named[0] if s.named else s.verdict] += 1
    columns = sorted({said for _, said in counts})
    rows = sorted({truth for truth, _ in counts})
    return columns, [(truth, [counts[truth, said] for said in columns]) for truth in rows]


def _row(s: Score) -> str:
    mark = {"nothing": "(nothing)", "outside": "outside: ", "changed": "changed: "}
    return mark.get(s.category, "") + (s.truth[0] if s.truth else "")


def detection(scores: Sequence[Score]) -> list[tuple[str, str, str]]:
    """Observable share of torque RMS, right (alone or set), wrong: for single effects."""
    single = [s for s in scores if s.category == "single"]
    rows = []
    for low, high in pairwise(BINS):
        part = [s for s in single if low <= s.observable[0] < high]
        name = f"{100 * low:.1f} to {100 * high:.1f} %" if high < 1 else f"over {100 * low:.1f} %"
        rows.append((name, share(*_count(part, "alone", "set")), share(*_count(part, "wrong"))))
    return rows


def gaps(scores: Sequence[Score]) -> list[tuple[str, str]]:
    """Closed share of the gap on locked runs, where something was added: of all above the floor,
    and, of effects that are to be seen, of what the effect itself had made."""
    rows = []
    for outcome in ("alone", "set", "both", "some", "wrong"):
        named = [s for s in scores if s.outcome == outcome]
        rows += _closed(outcome, [s.closed_gap for s in named])
        rows += _closed("  seen, the effect's own", [s.closed_effect for s in named])
    return rows


def _closed(name: str, shares: Iterable[float | None]) -> list[tuple[str, str]]:
    found = [f for f in shares if f is not None]
    enough = share(sum(f >= 0.9 for f in found), len(found))
    line = f"median {100 * median(found):.1f} %; 90 % closed in {enough}" if found else ""
    return [(name, line)] if found else []


def text(scores: Sequence[Score]) -> str:
    """All tables, as printed."""
    lines = [f"{len(scores)} cases, {sum(s.closed for s in scores)} by a full closed loop", ""]
    lines += [f"{claim:36s} {wanted:8s} {found}" for claim, wanted, found in targets(scores)]
    lines += ["", "observable      right                              wrong"]
    lines += [f"{name:15s} {right:34s} {wrong}" for name, right, wrong in detection(scores)]
    lines += ["", "gap closed on locked runs"]
    lines += [f"{outcome:24s} {found}" for outcome, found in gaps(scores)] or ["no case"]
    columns, rows = confusion(scores)
    lines += ["", "confusion, truth down, said across (first name):"]
    lines += [f"  {k:2d} {name}" for k, name in enumerate(columns)]
    lines += [" " * 38 + " ".join(f"{k:3d}" for k in range(len(columns)))]
    lines += [f"{truth:38s}" + " ".join(f"{n or '.':>3}" for n in row) for truth, row in rows]
    return "\n".join(lines)
