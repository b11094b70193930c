"""What is too faint for a name, and bends the values of what has one.

Friction that grows with the rate adds too little to dry friction to be worth a name, or no more
than an error of its form may. Dry friction takes it up, and is larger by all that it is; or it is
only an error of the form. Nobody knows, so intervals hold with it and without it.
"""

from __future__ import annotations

from collections.abc import Sequence

from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.selection.bars import chance, repeated, shown
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.firm import firm
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.select import Selection
from flexhex.diagnosis.selection.unrefuted import Fitted


def with_faint(
    now: Fitted, selection: Selection, criteria: Criteria, listed: Sequence[Score]
) -> tuple[list[Accepted], Joint] | None:
    """Effects with those that have no name as they are faint, and the fit of all; None where there
    is none, or others would not stay as they are. listed: all scores."""
    more = _faint(now.effects, selection, criteria)
    if not more:
        return None
    there = [*now.effects, *more]
    kept, fit = firm(now.fit.bench, there, criteria, now.freed, listed)
    return (kept, fit) if len(kept) > len(now.effects) and _all(now.effects, kept) else None


def _all(effects: Sequence[Accepted], kept: Sequence[Accepted]) -> bool:
    return all(any(one is each for one in kept) for each in effects)


def _faint(effects: Sequence[Accepted], selection: Selection, criteria: Criteria) -> list[Accepted]:
    """Beside each axis' effects whose form is not exact the effect of one number that predicts
    most, if that is more than chance."""
    known, bars = selection.search.known(), selection.search.bars
    number, faint = len(selection.rounds), list[Accepted]()
    for axis in {a.score.hypothesis.axis for a in effects if a.named and not _exact(a.score)}:
        good = [
            score
            for score in selection.rounds[-1]
            if score.hypothesis.axis == axis
            and score.hypothesis.freedom == 1
            and isinstance(score.hypothesis, EffectHypothesis)
            and score.gain > chance(score, known, bars)
            and shown(score, criteria, repeated(score, known))
        ]
        if good:
            best = max(good, key=lambda score: score.gain)
            faint.append(Accepted(best, (), number, named=False, faint=True))
    return faint


def _exact(score: Score) -> bool:
    return isinstance(score.hypothesis, EffectHypothesis) and score.hypothesis.exact
