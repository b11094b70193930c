"""What errors in the form of accepted effects may have left for a hypothesis to gain.

Columns of these errors (`form.py`) are smooth; nature need not be. An error of the form of a torque
t is t times a factor of angle, rate and torque, or t that comes early or late, or turns over within
a wider angle. A hypothesis may gain by it only as far as its own torque is made so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.bars import Bars, form_error
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import together
from flexhex.diagnosis.selection.form import space_of_errors
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import Axis, EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.scores import Score, torque_beyond

Array = NDArray[np.float64]


def with_blur(
    bars: Bars,
    moments: Moments,
    plain: Callable[[], Moments],
    hypotheses: Hypotheses,
    known: Sequence[tuple[Score, tuple[Term, ...]]],
    criteria: Criteria,
) -> Bars:
    """Bars with what errors in the form of what was accepted may have left; plain: the model
    without columns of these errors. Effects of an axis may share what they gain: of these it is the
    gain of all together."""
    blur = dict[Axis, float]()
    for axis in {score.hypothesis.axis for score, _ in known}:
        there = [(score, both) for score, both in known if score.hypothesis.axis == axis]
        own = [(score, both) for score, both in there if both]
        left = sum(_left(score, criteria) for score, _ in there)
        alone = sum(score.gain for score, _ in own)
        if len(own) > 1 and alone > 0:
            whole = together(moments, [term for _, both in own for term in both])
            left *= max(whole / alone, 1.0)
        blur[axis] = left

    @cache
    def spaces(axis: int) -> list[tuple[float, Array]]:
        own = [(score, both[0]) for score, both in known if both and score.hypothesis.axis == axis]
        listed = [_torques(plain(), hypotheses, *each) for each in own]
        pairs = zip(own, listed, strict=True)
        rows = hypotheses.rows
        return [(_left(s, criteria), space_of_errors(rows, axis, *t)) for (s, _), t in pairs]

    def alike(score: Score) -> float:
        axis = score.hypothesis.axis
        if not isinstance(score.hypothesis, EffectHypothesis) or axis is None:
            return 1.0
        torque = torque_beyond(plain(), hypotheses, score)
        square = float(torque @ torque)
        if square == 0:
            return 1.0
        shares = [(left, float(((s.T @ torque) ** 2).sum()) / square) for left, s in spaces(axis)]
        return sum(left * share for left, share in shares) / sum(left for left, _ in shares)

    return replace(bars, blur=blur, alike=alike)


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
