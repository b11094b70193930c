"""What is left without a name, and how much of it leaves effects theirs."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from flexhex.diagnosis.selection.bars import form_error, shown
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.orders import fundamental_of, fundamentals
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.select import Selection


@dataclass(frozen=True)
class Nameless:
    """Something without a name: relative RMS, beside what was accepted and, whole, in its place;
    what it goes with, where that is known; what it would gain to explain it [nats]; form: no more
    of it goes with the motion than errors in the form of what was accepted there may leave;
    instead: what was accepted there and only imitates it; beyond: relative RMS of what repeats and
    goes with nothing that the axis does."""

    size: float
    whole: float
    what: str = ""
    gain: float = np.inf
    form: bool = True
    instead: tuple[Accepted, ...] = ()
    beyond: float = np.inf


def nameless(
    selection: Selection, criteria: Criteria, named: Container[int | None] = ()
) -> dict[int, Nameless]:
    """Axes on which something without a name is left: smooth in the motion, or of any other form as
    long as it repeats. On one trajectory alone only what repeats counts, and what was found there
    explains nothing unless it is among the axes that are `named`."""
    after = [selection.arbitrated or axis in named for axis in range(len(selection.rest))]
    pairs = zip(selection.rest, selection.before, after, strict=True)
    rest = [one if there else other for one, other, there in pairs]
    chance = log(len(rest) / criteria.false_alarms)
    functions, besides = dict[int, Nameless](), [each.beside for each in selection.imitated]
    for axis, (left, beside) in enumerate(zip(rest, besides, strict=True)):
        own = [a for a in selection.accepted if a.score.hypothesis.axis == axis]
        sizes = tolerated(own, selection.explained[axis], criteria)
        least = min(criteria.smallest_rest, max(sizes, default=np.inf))
        # what repeats is the size of what goes with the motion, too, where it is well known; beside
        # effects else by what both gain, as slow parts of it are hardly determined
        sure = left.deviations > criteria.deviations
        goes = selection.arbitrated and beside.gain > chance and shown(beside, criteria)
        gain = sum(a.score.gain for a in own)
        other = selection.explained[axis] * np.sqrt(beside.gain / gain) if goes and own else np.inf
        size = left.size if sure else min(beside.size, float(other)) if goes else 0.0
        if size > least:
            what = beside.hypothesis.id if goes else ""
            # on other axes base parameters alone move with what was accepted elsewhere
            whole = float(np.hypot(selection.explained[axis] if own and after[axis] else 0.0, size))
            worth = max(left.gain, beside.gain if goes else 0.0)
            error = selection.explained[axis] * _inexact(own, criteria)
            form = not goes or min(size, beside.size) <= error
            beyond = selection.imitated[axis].beyond
            functions[axis] = Nameless(size, whole, what, worth, form, beyond=beyond)
    for axis, each in enumerate(selection.imitated):
        own = [a for a in selection.effects if a.score.hypothesis.axis == axis]
        instead, places = each.instead, each.places
        what = instead.hypothesis.id if instead else "angle"
        if instead is None:
            # what is wrong with the form of a function of the angle is one itself
            places = _only_parts(own, each.placed, each.angle, selection, criteria)
        if not places or not (selection.arbitrated or axis in named):
            continue
        # what was accepted only imitates it, and has no part in what is explained
        there = tuple(own[k] for k in places)
        part = _share(there, own, instead) * selection.explained[axis]
        size, whole = np.hypot([part, selection.explained[axis]], rest[axis].size)
        form = bool(size <= selection.explained[axis] * _inexact(own, criteria))
        functions[axis] = Nameless(
            float(size), float(whole), what, form=form, instead=there, beyond=each.beyond
        )
    return functions


def _only_parts(
    own: Sequence[Accepted],
    placed: Sequence[int],
    size: float,
    selection: Selection,
    criteria: Criteria,
) -> tuple[int, ...]:
    """Places of the functions of the angle that are only parts of one that has no name; size: of
    that beside them, relative RMS. A part is too small to keep its name beside it (and beside the
    other parts), and it could take the part's place, as it cannot that of a faster wave."""
    if not placed:
        return ()
    explained = selection.explained[own[0].score.hypothesis.axis or 0]
    most, parts = tolerated(own, explained, criteria), list[int]()
    while True:
        whole = np.hypot(size, explained * _share([own[k] for k in parts], own))
        small = [k for k in placed if k not in parts and whole > most[k]]
        more = [k for k in small if selection.imitates(own[k])]
        if not more:
            return tuple(sorted(parts))
        parts += more


def _share(
    some: Sequence[Accepted], every: Sequence[Accepted], instead: Score | None = None
) -> float:
    """The torque of some effects, relative to that of all, by what they gain: sizes of slow ones
    that cancel each other are hardly determined. instead: what takes their place and gains as much
    as all of them together."""
    rest = sum(a.score.gain for a in every if a not in some)
    own = instead.gain if instead else sum(a.score.gain for a in some)
    return float((own / max(own + rest, np.finfo(float).tiny)) ** 0.5)


def _inexact(accepted: Sequence[Accepted], criteria: Criteria) -> float:
    """Error of the form of some effects together, relative to their torque."""
    scores = [a.score for a in accepted]
    errors = [form_error(score, criteria) * _part([score], scores) for score in scores]
    return float(np.linalg.norm(errors))


def tolerated(accepted: Sequence[Accepted], explained: float, criteria: Criteria) -> list[float]:
    """Relative RMS of a rest on an axis that leaves each of its effects its name, by its part of
    what they explain together; harmonics of one wave count together."""
    scores = [a.score for a in accepted]
    lowest = fundamentals([score.order for score in scores if score.order is not None])
    sizes = list[float]()
    for score in scores:
        own = [score]
        if score.order is not None:
            wave = fundamental_of(score.order, lowest)
            own = [s for s in scores if s.order and fundamental_of(s.order, lowest) == wave]
        most = criteria.varied_rest if score.hypothesis.varied else criteria.largest_rest
        sizes.append(most * explained * _part(own, scores))
    return sizes


def _part(some: Sequence[Score], every: Sequence[Score]) -> float:
    """The torque of some effects, relative to that of all."""
    squares = [sum(score.size**2 for score in scores) for scores in (some, every)]
    return float((squares[0] / max(squares[1], np.finfo(float).tiny)) ** 0.5)
