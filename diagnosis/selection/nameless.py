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
    of it goes with the motion than errors in the form of what was accepted there may leave."""

    size: float
    whole: float
    what: str = ""
    gain: float = np.inf
    form: bool = True


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
            functions[axis] = Nameless(size, whole, what, worth, form)
    for axis, each in enumerate(selection.imitated):
        if each.instead is None or not (selection.arbitrated or axis in named):
            continue
        # what was accepted only imitates it, and has no part in what is explained
        own = [a for a in selection.effects if a.score.hypothesis.axis == axis]
        scores = [a.score for a in own]
        share = _part([scores[k] for k in each.places], scores)
        size, whole = np.hypot(np.array([share, 1.0]) * selection.explained[axis], rest[axis].size)
        form = size <= selection.explained[axis] * _inexact(own, criteria)
        functions[axis] = Nameless(
            float(size), float(whole), each.instead.hypothesis.id, form=bool(form)
        )
    return functions


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
