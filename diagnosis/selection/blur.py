"""What errors in the form of accepted effects may have left for a hypothesis to gain.

Columns of these errors (`form.py`) are smooth; nature need not be, above all not where friction
turns over. An error of the form of a torque
t is t times a factor of angle, rate and torque, or t that comes early or late, or turns over within
a wider angle. A hypothesis may gain by it only as far as its own torque is made so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.bars import form_error
from flexhex.diagnosis.selection.changed import Axis
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import together
from flexhex.diagnosis.selection.form import Space, space_of_errors
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.left import rest_on
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.scores import Score, effect_term, torque_beyond

Array = NDArray[np.float64]


Pair = tuple[Score, tuple[Term, ...]]
"""What was accepted, and its terms: its columns and those of the error of its form; none of a
parameter."""


@dataclass(frozen=True, eq=False)
class Blur:
    """Of a score, what it may gain by errors in the form of what is known [nats].

    moments: the model with what is known; plain: the same without columns of these errors.
    """

    moments: Moments
    plain: Callable[[], Moments]
    hypotheses: Hypotheses
    known: Sequence[Pair]
    criteria: Criteria

    def __call__(self, score: Score) -> float:
        return felt(score, self.left, self._taken)

    @cached_property
    def left(self) -> Mapping[Axis, float]:
        """What these errors may have left on each axis, or on all [nats]. Effects of an axis may
        share what they gain: of these it is the gain of all together."""
        left = dict[Axis, float]()
        for axis in {score.hypothesis.axis for score, _ in self.known}:
            own = self._own(axis)
            total = sum(_left(s, self.criteria) for s, _ in self.known if s.hypothesis.axis == axis)
            alone = sum(score.gain for score, _ in own)
            if len(own) > 1 and alone > 0:
                whole = together(self.moments, [term for _, both in own for term in both])
                total *= max(whole / alone, 1.0)
            left[axis] = total
        return left

    def alike(self, score: Score) -> float:
        """Share of a hypothesis' torque, in squares, that has the form of such errors on its
        axis: all of it where a parameter is known there, whose errors have no form of their own."""
        axis = score.hypothesis.axis
        if not isinstance(score.hypothesis, EffectHypothesis) or axis is None:
            return 1.0
        torque = torque_beyond(self.plain(), self.hypotheses, score)
        square = float(torque @ torque)
        if square == 0:
            return 1.0
        shares = [(left, space.square(torque) / square) for left, space in self._spaces(axis)]
        shares += [
            (_left(known, self.criteria), 1.0)
            for known, both in self.known
            if not both and known.hypothesis.axis == axis
        ]
        return sum(left * share for left, share in shares) / sum(left for left, _ in shares)

    def _taken(self, score: Score, left: float) -> float:
        """The most that a hypothesis can have gained on its axis from errors that left as much as
        `left` there [nats]. It can imitate the share `alike` of such an error at most, and cannot
        remove the rest: so what is left beside it, as much as chance may hide of that, bounds what
        it gained from the error."""
        axis, alike = score.hypothesis.axis, min(self.alike(score), 1.0)
        if axis is None or alike == 1.0 or alike * left == 0.0:
            return alike * left
        longer = self.plain().extended(effect_term(self.plain(), self.hypotheses, score))
        rest = rest_on(longer, axis, longer.fit(None).q)
        if not rest.deviations:
            return alike * left
        most = rest.gain * (1.0 + self.criteria.deviations / rest.deviations)
        return min(alike * left, alike / (1.0 - alike) * most)

    def _spaces(self, axis: int) -> Sequence[tuple[float, Space]]:
        if axis not in self._made:
            listed = list[tuple[float, Space]]()
            for score, both in self._own(axis):
                torques = _torques(self.plain(), self.hypotheses, score, both[0])
                space = space_of_errors(self.hypotheses.rows, axis, *torques)
                listed.append((_left(score, self.criteria), space))
            self._made[axis] = listed
        return self._made[axis]

    @cached_property
    def _made(self) -> dict[int, Sequence[tuple[float, Space]]]:
        """Spaces of errors that were asked for."""
        return {}

    def _own(self, axis: Axis) -> list[Pair]:
        """What an axis has, without parameters."""
        return [
            (score, both) for score, both in self.known if both and score.hypothesis.axis == axis
        ]


def felt(score: Score, left: Mapping[Axis, float], taken: Callable[[Score, float], float]) -> float:
    """Of what errors have left on each axis [nats], what a hypothesis may gain by it: as far as it
    is felt there, of those on its axis what it can have taken, of those on other axes no more than
    it gains there."""
    axis = score.hypothesis.axis

    def gained(other: Axis, own: float) -> float:
        if axis is None or other is None:
            return own
        share = score.spread[other] if score.spread else float(other == axis)
        return share * (taken(score, own) if other == axis else min(own, score.gain))

    return sum(gained(other, own) for other, own in left.items() if own > 0)


def _left(score: Score, criteria: Criteria) -> float:
    return form_error(score, criteria) ** 2 * score.gain


def _torques(
    moments: Moments, hypotheses: Hypotheses, score: Score, term: Term
) -> tuple[Array, list[Array]]:
    """Whitened torque (R,) of an accepted effect on its axis, and that with each wider shape of
    those that machines have several of at once."""
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    assert effect.axis is not None
    gains = moments.fit(None).q[moments.place(term)]
    there = [k for k in range(effect.width) if k not in score.still]
    wider, shape = list[Array](), hypotheses.blended(effect, effect.shapes[score.shape])
    while shape is not None:
        columns = hypotheses.columns(effect, shape).white[effect.axis]
        wider.append(columns[:, there] @ gains[: len(there)])
        shape = hypotheses.blended(effect, shape)
    return term.white[effect.axis] @ gains, wider
