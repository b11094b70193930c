"""What many scores say together: shares with Wilson intervals, confusion, detection, gaps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

from results.shares import share
from studies.score import Score

SEEN = 0.004
"""Effects of which at least this share of torque RMS is observable have to be found."""
Endings = tuple[tuple[str, str, tuple[str, ...]], ...]
NOTHING: Endings = (
    ("an effect named", "at most 1 %", ("false_alarm",)),
    ("`unknown`", "", ("unknown",)),
)
SINGLE: Endings = (
    ("named alone, axes right", "at least 80 %", ("alone",)),
    ("in a set of two or three, axes right", "", ("set",)),
    ("name right, axes wrong in part", "", ("joints",)),
    ("missed", "", ("missed",)),
    ("wrong", "at most 2 %", ("wrong",)),
)
FAINT: Endings = tuple((name, "" if "alone" in name else w, o) for name, w, o in SINGLE)
OUTSIDE: Endings = (
    ("detected: `unknown`", "at least 90 %", ("detected",)),
    ("not noticed: `none` or `changed`", "", ("unnoticed",)),
    ("an effect named", "at most 3 %", ("wrong",)),
)
PAIR: Endings = (
    ("both named alone, axes right", "", ("alone",)),
    ("both named, a set among them", "", ("set",)),
    ("both named, axes wrong in part", "", ("joints",)),
    ("some named", "", ("some",)),
    ("missed", "", ("missed",)),
    ("a wrong name", "at most 3 %", ("wrong",)),
)
CHANGED: Endings = (
    ("right", "at least 95 %", ("right",)),
    ("missed", "", ("missed",)),
    ("wrong", "", ("wrong",)),
)
BINS = (0.0, 0.001, 0.002, 0.004, 0.006, 0.01, 0.02, 1.0)


@dataclass(frozen=True)
class Claim:
    """How many of n cases ended in one way, and how many are wanted."""

    kind: str
    ending: str
    wanted: str
    hits: int
    n: int


def claims(scores: Sequence[Score]) -> list[Claim]:
    """Every ending that was wanted or is to be avoided, kind by kind."""
    of = {c: [s for s in scores if s.category == c] for c in {s.category for s in scores}}
    single, pairs = of.get("single", []), of.get("pair", [])
    seen = [s for s in single if s.observable[0] >= SEEN]
    both = [s for s in pairs if min(s.observable) >= SEEN]
    listed = [
        ("nothing hidden", of.get("nothing", []), NOTHING),
        (f"one effect, observable part at least {SEEN:.1%} of torque RMS", seen, SINGLE),
        ("one effect, observable part less", [s for s in single if s not in seen], FAINT),
        ("outside the library", of.get("outside", []), OUTSIDE),
        ("two effects, both observable", both, PAIR),
        ("two effects, all cases", pairs, PAIR),
        ("a parameter changed", of.get("changed", []), CHANGED),
        ("machines of one to three effects", of.get("machine", []), PAIR),
    ]
    found = []
    for kind, part, endings in listed:
        for ending, wanted, outcomes in endings:
            hits = sum(s.outcome in outcomes for s in part)
            found.append(Claim(kind, ending, wanted, hits, len(part)))
    return found


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


def detection(scores: Sequence[Score]) -> list[tuple[str, str, str, str]]:
    """Observable share of torque RMS, named alone, in a set, wrong: for single effects."""
    single = [s for s in scores if s.category == "single"]
    rows = []
    for low, high in pairwise(BINS):
        part = [s for s in single if low <= s.observable[0] < high]
        name = f"{100 * low:.1f} to {100 * high:.1f} %" if high < 1 else f"over {100 * low:.1f} %"
        counts = (sum(s.outcome == o for s in part) for o in ("alone", "set", "wrong"))
        alone, several, wrong = (share(hits, len(part)) for hits in counts)
        rows.append((name, alone, several, wrong))
    return rows


def gaps(scores: Sequence[Score]) -> list[tuple[str, str]]:
    """Closed share of the gap on locked runs, where something was added: of all above the floor,
    and, of effects that are to be seen, of what the effect itself had made."""
    rows = []
    for outcome in ("alone", "set", "joints", "some", "wrong"):
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
    for c in claims(scores):
        lines.append(f"{c.kind}: {c.ending}: {share(c.hits, c.n)} {c.wanted and f'({c.wanted})'}")
    lines += ["", "observable part: named alone; in a set; wrong"]
    lines += ["; ".join(row) for row in detection(scores)]
    lines += ["", "gap closed on locked runs"]
    lines += [f"{outcome:24s} {found}" for outcome, found in gaps(scores)] or ["no case"]
    columns, rows = confusion(scores)
    lines += ["", "confusion, truth down, said across (first name):"]
    lines += [f"  {k:2d} {name}" for k, name in enumerate(columns)]
    lines += [" " * 38 + " ".join(f"{k:3d}" for k in range(len(columns)))]
    lines += [f"{truth:38s}" + " ".join(f"{n or '.':>3}" for n in row) for truth, row in rows]
    return "\n".join(lines)
