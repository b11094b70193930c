"""The shapes of a large grid, as many of them as it takes to see where its evidence is."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.evidence import Tried, tried
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Left, Moments

Array = NDArray[np.float64]
Step = tuple[int, ...]
MANY = 50
"""Shapes of a grid of which all are tried."""
SHARE, CHANCE = 0.3, 3.0
"""Part of the best evidence, less so many nats, from which the shapes beside one are tried. Half a
step of a mode's grid beside one, and at three times its damping or a third of it, a shape of the
grid explains at least 0.4 of what the best one between them would."""


def steps_of(shapes: Sequence[Mapping[str, float]]) -> list[Step]:
    """Places of the shapes of a grid along each of its values."""
    values = {name: sorted({shape[name] for shape in shapes}) for name in shapes[0]}
    places = {name: {v: k for k, v in enumerate(own)} for name, own in values.items()}
    return [tuple(places[name][shape[name]] for name in places) for shape in shapes]


def beside(step: Step, at: Mapping[Step, int]) -> Iterator[int | None]:
    """Places of the shapes one step beside one; None beyond the grid."""
    for i, own in enumerate(step):
        for way in (-1, 1):
            yield at.get((*step[:i], own + way, *step[i + 1 :]))


def first_of(shapes: Sequence[Mapping[str, float]], searched: Collection[str]) -> tuple[int, ...]:
    """Places of every second value of each shape that may take any value: all others of a large
    grid are beside one of these. Nothing where all are tried."""
    if len(shapes) <= MANY:
        return ()
    steps = steps_of(shapes)
    ends = np.max(steps, axis=0)
    halved = [i for i, name in enumerate(shapes[0]) if name in searched and ends[i] > 0]
    return tuple(k for k, step in enumerate(steps) if all(step[i] % 2 for i in halved))


def surveyed(moments: Moments, effect: EffectHypothesis) -> dict[Left, Tried]:
    """An effect beside a model, see `tried`: those of its shapes that are looked at first, and then
    all that are beside promising ones. The others have no evidence."""
    if not effect.first:
        return tried(moments, effect)
    count, steps = len(effect.shapes), steps_of(effect.shapes)
    at = {step: k for k, step in enumerate(steps)}
    fits = {left: _nothing(count, effect.width) for left in (None, *moments.rows.folds)}
    done, wanted = set[int](), set(effect.first)
    while wanted:
        places = sorted(wanted)
        some = replace(
            effect,
            shapes=tuple(effect.shapes[k] for k in places),
            known=tuple(effect.known[k] for k in places),
            first=(),
        )
        for left, own in tried(moments, some).items():
            whole = fits[left]
            whole.evidence[places], whole.gains[places] = own.evidence, own.gains
            whole.odd[places] = own.odd
        done |= wanted
        around = (beside(steps[k], at) for k in _promising(fits))
        wanted = {k for own in around for k in own if k is not None} - done
    return fits


def _nothing(count: int, width: int) -> Tried:
    evidence = np.full(count, -np.inf)
    return Tried(evidence, np.zeros((count, width)), np.zeros(count, dtype=bool))


def _promising(fits: Mapping[Left, Tried]) -> list[int]:
    """Places of the shapes that have a good part of the best evidence of any fit."""
    there = [
        fit.evidence >= SHARE * max(float(fit.evidence.max()), 0.0) - CHANCE
        for fit in fits.values()
    ]
    return np.flatnonzero(np.any(there, axis=0)).tolist()
