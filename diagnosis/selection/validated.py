"""What held-out runs say of effects: alone, where nothing else can (of an only trajectory, or run
once), and where they speak against what the others say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, axis_rms, joint
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.result.verdict import WORSE
from flexhex.diagnosis.selection.bars import shown
from flexhex.diagnosis.selection.choose import Accepted, simplest
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.firm import grouped
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score

Array = NDArray[np.float64]


def refuted(fit: Joint, others: Elsewhere | None) -> tuple[list[int], bool]:
    """Axes (from 0) of which a fit leaves more on held-out runs than the base model's own does, and
    whether it does of all together."""
    if others is None:
        return [], False
    before, after = _left_of_base(fit, others), _left(fit, others)
    worse = [int(i) for i in np.flatnonzero(after > WORSE * before)]
    return worse, bool(np.linalg.norm(after) > WORSE * np.linalg.norm(before))


def better(fit: Joint, without: Joint, others: Elsewhere, times: float = 1.0) -> bool:
    """Whether a fit leaves less of the held-out runs, on all axes together, than so many times what
    one without some of its effects or parameters does: base parameters that an effect no longer
    bends may help other axes; that their tolerances do not hold them hardly shows there."""
    left, most = (float(np.linalg.norm(_left(one, others))) for one in (fit, without))
    return left < times * most


def _left(fit: Joint, others: Elsewhere) -> Array:
    """What a fit leaves on held-out runs, RMS (n,) relative to the torque of the others."""
    left = axis_rms(others.blocks, others.residual(fit.parts, fit.beta, fit.q))
    return np.asarray(left / fit.bench.model.torque_rms)


def _left_of_base(fit: Joint, others: Elsewhere) -> Array:
    """The same of the base model's own fit."""
    model = fit.bench.model
    left = axis_rms(others.blocks, others.residual((), (), model.regression.q))
    return np.asarray(left / model.torque_rms)


def validated(
    bench: Bench,
    accepted: Sequence[Accepted],
    others: Elsewhere | None,
    criteria: Criteria,
    rounds: Sequence[Sequence[Score]],
) -> list[Accepted]:
    """Effects that explain on held-out runs, too, what they explain on the others, each beside
    those that were accepted before it. What is found on an only trajectory, or where nothing is run
    twice, may be something else: noise of the angles, for one. Then the next best effect of its
    axis and of its round takes its place, if it explains these."""
    if others is None:
        return []
    least, kept = criteria.smallest_effect * bench.model.torque_rms, list[Accepted]()
    own = axis_rms(bench.model.blocks, joint(bench, ()).residual)
    left = axis_rms(others.blocks, others.beside((), ()))
    for each in accepted:
        for option in options(each, rounds, criteria):
            fit, axis = joint(bench, grouped(bench, [*kept, option])), option.score.hypothesis.axis
            there = axis_rms(bench.model.blocks, fit.residual)
            now = axis_rms(others.blocks, others.beside(fit.parts, fit.beta))
            known, predicted = 1 - (there / own) ** 2, 1 - (now / left) ** 2
            better = (left**2 - now**2 > least**2) & (predicted > criteria.predicted * known)
            if better.any() if axis is None else better[axis]:
                kept, own, left = [*kept, option], there, now
                break
    return kept


def options(
    accepted: Accepted, rounds: Sequence[Sequence[Score]], criteria: Criteria
) -> Iterator[Accepted]:
    """What was accepted, then what would have been in its round without those before it."""
    yield accepted
    first = accepted.score.hypothesis
    left = [
        s
        for s in rounds[accepted.round - 1]
        if isinstance(s.hypothesis, EffectHypothesis) and shown(s, criteria)
        if s.hypothesis.axis == first.axis and s.hypothesis.id != first.id
    ]
    while left:
        yield (option := simplest(left[0], left, accepted.round, criteria))
        left = [s for s in left if s is not option.score]
