"""What held-out runs say of effects where nothing else can: of an only trajectory, or of runs that
were not repeated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import joint
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.selection.bars import shown
from flexhex.diagnosis.selection.choose import Accepted, simplest
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.firm import grouped
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score

Array = NDArray[np.float64]


def validated(
    bench: Bench,
    accepted: Sequence[Accepted],
    others: Elsewhere | None,
    criteria: Criteria,
    rounds: Sequence[Sequence[Score]],
    freed: Mapping[int, float],
) -> list[Accepted]:
    """Effects that explain on held-out runs, too, what they explain on the others, each beside all
    others. What is found on an only trajectory, or where nothing is run twice, may be something
    else: noise of the angles, for one. Then the next best effect of its axis and of its round takes
    its place, if it explains these."""
    if others is None:
        return []
    seen = Predicted(bench, others, criteria, freed)
    kept, gone = list(accepted), set[Score]()
    while kept:
        margins = [seen.margin(each, kept[:k] + kept[k + 1 :]) for k, each in enumerate(kept)]
        place = int(np.argmin(margins))
        if margins[place] > 0:
            break
        worst = kept.pop(place)
        gone.add(worst.score)
        asked = (o for o in options(worst, rounds, criteria) if o.score not in gone)
        better = next((o for o in asked if seen.margin(o, kept) > 0), None)
        kept += [better] if better else []
    return kept


class Predicted:
    """What effects explain of held-out runs beside others, in the noise of the fit; every set is
    fitted once.

    freed: inverse variances of base parameters that left their tolerances.
    """

    def __init__(
        self, bench: Bench, others: Elsewhere, criteria: Criteria, freed: Mapping[int, float]
    ) -> None:
        self.bench, self.others, self.criteria, self.freed = bench, others, criteria, freed
        self._left: dict[frozenset[Score], list[Array]] = {}

    def margin(self, each: Accepted, beside: Sequence[Accepted]) -> float:
        """What an effect explains of the squares of held-out runs beside others, less a part of
        those of the torque that it makes there, or of all that is left there if that is less,
        relative to the torque's. It explains all of the torque that it makes if it is as the other
        runs say, and none if it is another. At most zero for one that explains less than is worth a
        name."""
        without, left = self._of(beside), self._of([*beside, each])
        made, there = [a - b for a, b in zip(without, left, strict=True)], self.others.there
        torque = self.bench.model.torque_rms
        before, after, own = (unpredicted(there, rows) / torque for rows in (without, left, made))
        explained = before**2 - after**2
        margin = explained - self.criteria.predicted * np.minimum(own, before) ** 2
        small = explained <= self.criteria.smallest_effect**2
        margin = np.where(small, np.minimum(margin, 0.0), margin)
        axis = each.score.hypothesis.axis
        return float(margin.max() if axis is None else margin[axis])

    def _of(self, effects: Sequence[Accepted]) -> list[Array]:
        """What is left beside effects (m, n) [N m] of each block of the held-out runs."""
        key = frozenset(each.score for each in effects)
        if key not in self._left:
            fit = joint(self.bench, grouped(self.bench, effects), self.freed)
            self._left[key] = self.others.updated(fit)
        return self._left[key]


def unpredicted(model: Calibrated, left: Sequence[Array]) -> Array:
    """RMS (n,) [N m] of what is left (m, n) of each block; where passes show what is noise, beyond
    what that does after the moments before: slow torques, of which it has most, count little."""
    if not model.noise.repeats:
        return axis_rms(model.blocks, left)
    rows = [model.white(i, [own[:, i] for own in left]) for i in range(model.base.n)]
    return np.asarray([np.sqrt((own**2).mean()) for own in rows] * model.noise.scale)


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
