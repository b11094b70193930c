"""The table of many outcomes: what is wanted, what came out, of how many, with Wilson intervals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from results.tables import hidden
from studies.honest import OBSERVABLE, Outcome
from studies.honest_values import FAINT

FOUND = ("right", "ambiguous")
RIGHT = (*FOUND, "all")
FIFTHS = 5
CLOSED = 0.9
"""Share of what the effect adds to the residual of test runs that a right name is to remove."""
Has = Callable[[Outcome], bool]


@dataclass(frozen=True)
class Claim:
    """What is hidden, what is said of it, how much of that is wanted: `hits` of `n`; text: what a
    share does not say."""

    kind: str
    ending: str
    wanted: str
    hits: int
    n: int
    text: str = ""


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """Every row of the table, also those of which there is no case."""
    return [*_named(outcomes), *_estimated(outcomes), *_plain(outcomes), *_guarded(outcomes)]


def ended(*words: str) -> Has:
    """Outcomes that are one of these words."""
    return lambda o: o.outcome in words


def wrong(o: Outcome) -> bool:
    """Whether something is named that is not there."""
    return o.outcome in ("wrong", "false_alarm") or o.outcome.endswith("+wrong")


Endings = Sequence[tuple[str, str, Has]]


def _counted(kind: str, part: Sequence[Outcome], endings: Endings) -> Iterator[Claim]:
    for ending, wanted, has in endings:
        yield Claim(kind, ending, wanted, sum(has(o) for o in part), len(part))


def _named(outcomes: Sequence[Outcome]) -> Iterator[Claim]:
    """What was named, and what not, where passes repeat and another trajectory can decide."""
    outcomes = [o for o in outcomes if not o.alone]

    def of(*categories: str) -> list[Outcome]:
        return [o for o in outcomes if o.category in categories]

    def least(listed: Sequence[Outcome], size: float) -> list[Outcome]:
        return [o for o in listed if o.observable and min(o.observable) >= size]

    single, outside, changes = of("single"), of("outside"), of("changed", "payload")
    # a payload that is announced is nothing hidden
    empty = of("nothing")
    empty += [o for o in changes if not o.observable and o.outcome in ("silent", "false_alarm")]
    seen, pairs = least(single, FAINT), least(of("pair", "plain"), OBSERVABLE)
    placed = [o for o in seen if o.outcome in (*FOUND, "right_name_wrong_axes")]
    empty_ends = (
        ("silent", "", ended("silent")),
        ("an effect named", "at most 1 %", ended("false_alarm")),
        ("`unknown`", "", ended("unknown")),
    )
    single_ends = (
        ("right, alone or among at most three", "at least 95 %", ended(*FOUND)),
        ("right, alone", "at least 80 %", ended("right")),
        ("wrong", "at most 2 %", wrong),
        ("missed", "", ended("missed", "cannot_tell")),
        ("`unknown`", "", ended("unknown")),
        ("refused or failed", "", ended("refused", "failed")),
    )
    yield from _counted("nothing hidden", empty, empty_ends)
    yield from _counted(
        f"one effect, at least {FAINT:.1%} of torque RMS observable", seen, single_ends
    )
    axes = ("of the right names, right axes", "at least 95 %", ended(*FOUND))
    yield from _counted(
        f"one effect, at least {FAINT:.1%} of torque RMS observable", placed, [axes]
    )
    faint = [o for o in single if o not in seen]
    yield from _counted("one effect, fainter", faint, [("wrong", "at most 2 %", wrong)])
    outside_ends = (
        ("`unknown`", "at least 90 %", ended("detected")),
        ("a name", "at most 3 %", wrong),
        ("missed", "", ended("missed", "cannot_tell")),
    )
    clear = least(outside, OBSERVABLE)
    yield from _counted(
        f"outside the library, at least {OBSERVABLE:.0%} observable", clear, outside_ends
    )
    pair_ends = (
        ("both", "at least 85 %", ended("all")),
        ("one of them", "", ended("some", "some+wrong")),
        ("a wrong name", "at most 3 %", wrong),
    )
    yield from _counted(f"two effects, both at least {OBSERVABLE:.0%}", pairs, pair_ends)
    hushed = [o for o in changes if o not in empty and min(o.observable, default=1.0) >= FAINT]
    change_ends = (("right", "at least 95 %", ended("right")), ("wrong", "", wrong))
    yield from _counted("changed parameters, payload between runs", hushed, change_ends)


def _estimated(outcomes: Sequence[Outcome]) -> Iterator[Claim]:
    """Intervals and confidence."""
    flat = [covered for o in outcomes for covered in o.covered.values()]
    coverage = "hold the true value"
    yield Claim("95 % intervals", coverage, "90 to 98 %", sum(flat), len(flat))
    for k in range(FIFTHS):
        group = [o for o in outcomes if o.named and _fifth(o.confidence) == k]
        hits = sum(o.outcome in RIGHT for o in group)
        mean = sum(o.confidence or 0.0 for o in group) / max(len(group), 1)
        ending = f"right where {20 * k} to {20 * (k + 1)} % is printed"
        text = f"{100 * mean:.0f} % printed" if group else ""
        yield Claim("confidence", ending, "within 5 points", hits, len(group), text)


def _fifth(confidence: float | None) -> int | None:
    return None if confidence is None else min(int(confidence * FIFTHS), FIFTHS - 1)


def _plain(outcomes: Sequence[Outcome]) -> Iterator[Claim]:
    """Axes with friction and cogging alone."""
    plain = [o for o in outcomes if o.category == "plain"]
    errors = [e for o in plain for k, e in o.errors.items() if k.startswith("coulomb_friction.F_c")]
    kind, n = "plain axes", len(errors)
    hits = sum(
        o.covered[k] for o in plain for k in o.covered if k.startswith("coulomb_friction.F_c")
    )
    mean = sum(errors) / max(n, 1)
    text = f"median error {median(errors):.1f}, mean {mean:.1f} standard deviations" if n else ""
    yield Claim(kind, "friction's interval holds the true value", "90 to 98 %", hits, n, text)

    def counted(of: Sequence[Outcome], start: str, ending: str, wanted: str, good: bool) -> Claim:
        values = [v for o in of for k, v in o.checks.items() if k.startswith(start)]
        return Claim(kind, ending, wanted, sum(v is good for v in values), len(values))

    yield counted(plain, "no delay", "a delay invented", "at most 1 %", False)
    # nothing is named where one trajectory only could show it
    decided = [o for o in plain if not o.alone]
    yield counted(decided, "order", "order of the cogging exact", "", True)
    yield counted(decided, "harmonic", "its harmonics named", "", True)


def _guarded(outcomes: Sequence[Outcome]) -> Iterator[Claim]:
    """What an answer must not say, and what it is worth."""
    alone = [o for o in outcomes if o.alone]
    blind = sum(bool(o.named) and not o.predicts for o in alone)
    kind, ending = "one trajectory or no repeats", "a name that does not predict the test runs"
    yield Claim(kind, ending, "none", blind, len(alone))
    visible = [o for o in alone if o.visible and o.category == "single"]
    yield Claim(
        kind, "of one effect: right", "", sum(o.outcome in FOUND for o in visible), len(visible)
    )
    yield Claim(kind, "of all: a wrong name", "", sum(map(wrong, alone)), len(alone))
    closed = [o.closed for o in outcomes if o.outcome in RIGHT and o.closed is not None]
    text = f"median {100 * median(closed):.0f} %" if closed else ""
    ending = f"at least {CLOSED:.0%} of what the effect adds to the residual of test runs removed"
    hits = sum(each >= CLOSED for each in closed)
    yield Claim("right names", ending, "all", hits, len(closed), text)
    physics = sum(o.impossible for o in outcomes)
    yield Claim(
        "physics", "a mass, inertia or damping at or below zero", "none", physics, len(outcomes)
    )


def families_of(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """The table as data: the claims of each family."""
    families = dict.fromkeys(o.family for o in outcomes)
    return {
        name: [asdict(c) for c in claims([o for o in outcomes if o.family == name])]
        for name in families
    }


def text(outcomes: Sequence[Outcome]) -> str:
    """The table for a terminal or a page, in Markdown."""
    return hidden({"families": families_of(outcomes)})
