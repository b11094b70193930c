"""What is left without a name, and how much of it leaves effects theirs."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from flexhex.diagnosis.selection.bars import shown
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.orders import fundamental_of, fundamentals
from flexhex.diagnosis.selection.select import Selection


@dataclass(frozen=True)
class Nameless:
    """Something without a name: relative RMS, beside what was accepted and, whole, in its place;
    what it goes with, where that is known; what it would gain to explain it [nats]."""

    size: float
    whole: float
    what: str = ""
    gain: float = np.inf


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
            functions[axis] = Nameless(size, whole, what, worth)
    for axis, each in enumerate(selection.imitated):
        if each.instead is None or not (selection.arbitrated or axis in named):
            continue
        # what was accepted only imitates it, and has no part in what is explained
        squares = [a.score.size**2 for a in selection.effects if a.score.hypothesis.axis == axis]
        share = (sum(squares[k] for k in each.places) / sum(squares)) ** 0.5
        size, whole = np.hypot(np.array([share, 1.0]) * selection.explained[axis], rest[axis].size)
        functions[axis] = Nameless(float(size), float(whole), each.instead.hypothesis.id)
    return functions


def tolerated(accepted: Sequence[Accepted], explained: float, criteria: Criteria) -> list[float]:
    """Relative RMS of a rest on an axis that leaves each of its effects its name, by its part of
    what they explain together; harmonics of one wave count together."""
    orders = [a.score.order for a in accepted]
    lowest = fundamentals([order for order in orders if order is not None])
    groups = [None if order is None else fundamental_of(order, lowest) for order in orders]
    squares = np.array([a.score.size**2 for a in accepted])
    sums = [
        own if group is None else sum(s for s, g in zip(squares, groups, strict=True) if g == group)
        for own, group in zip(squares, groups, strict=True)
    ]
    whole = max(float(squares.sum()), np.finfo(float).tiny)
    most = [
        criteria.varied_rest if a.score.hypothesis.varied else criteria.largest_rest
        for a in accepted
    ]
    parts = zip(most, sums, strict=True)
    return [share * explained * float(np.sqrt(own / whole)) for share, own in parts]
