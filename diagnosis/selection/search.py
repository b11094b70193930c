"""The search: the simplest hypothesis that predicts best is accepted, and those before it are
chosen anew beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, reduce

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.bars import bars_of, form_error
from flexhex.diagnosis.selection.blur import Blur
from flexhex.diagnosis.selection.changed import Axis, ChangedParameter
from flexhex.diagnosis.selection.choose import (
    Accepted,
    best_first,
    chosen,
    effect_scores,
    parameter_scores,
    unrepeated,
)
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.feedback import answers, noisy
from flexhex.diagnosis.selection.form import ARGUMENTS, LOADED, form_errors, inexact, limited
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis, Payload
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.parts import in_parts
from flexhex.diagnosis.selection.payload import payload_score
from flexhex.diagnosis.selection.scores import Score, blended_term, effect_term, with_shape

Array = NDArray[np.float64]


@dataclass
class Search:
    """The model as far as it was found. terms: of each accepted effect, its columns and those of
    the error of its form, none of a parameter; answered: feedback's answer to noise; scores: of
    each axis, of those that are stale beside a model before; longer: a model, a hypothesis, and the
    model with this and its terms."""

    hypotheses: Hypotheses
    criteria: Criteria
    accepted: list[Accepted] = field(default_factory=list)
    terms: list[tuple[Term, ...]] = field(default_factory=list)
    answered: tuple[Term, ...] = ()
    scores: dict[Axis, list[Score]] = field(default_factory=dict)
    stale: set[Axis] = field(default_factory=set)
    longer: tuple[Moments, Score, Moments, tuple[Term, ...]] | None = None

    def __post_init__(self) -> None:
        self.moments = self.hypotheses.moments
        self.bars = bars_of(self.hypotheses, self.criteria)
        self.stale = self._against(None)

    def next(self, number: int) -> tuple[Accepted | None, list[Score]]:
        """What is accepted next, and the scores that it was chosen from.

        What was accepted hardly moves the scores of other axes: these are computed anew when the
        best one is among them, or a parameter that competes with all axes, or none is good enough
        any more. Only then, and at first, a payload is looked for.
        """
        changes = parameter_scores(self.moments, self.hypotheses, self.criteria)
        while True:
            listed = best_first([*changes, *(s for own in self.scores.values() for s in own)])
            if not self.stale:
                known = self.known()
                payload = payload_score(self.moments, self.hypotheses, known, self.criteria)
                listed = best_first([*listed, payload]) if payload else listed
            accepted = self.chosen_of(listed, number)
            wanted = self.stale & (self._against(accepted) | _wider(accepted, listed))
            if not wanted:
                answered = self._answer(accepted)
                return self.next(number) if answered else (self._whole(accepted, listed), listed)
            for axis in wanted:
                self.scores[axis] = self.scores_of(axis)
            self.stale = self.stale - wanted

    def _whole(self, accepted: Accepted | None, listed: Sequence[Score]) -> Accepted | None:
        beside, known = (self.moments, self.hypotheses), self.known()
        return in_parts(*beside, accepted, listed, known, self.bars, self.criteria)

    def _answer(self, accepted: Accepted | None) -> bool:
        """Whether feedback's answer to noise is in the model now, in the place of this."""
        if self.answered or not noisy(self.hypotheses.rows):
            return False
        score = None if accepted is None else accepted.score
        terms = answers(self.moments, score, self.criteria)
        if terms:
            self.moments = reduce(Moments.extended, terms, self.moments)
            self.answered, self.stale = tuple(terms), self._against(None)
        return bool(terms)

    def _against(self, accepted: Accepted | None) -> set[Axis]:
        """Axes whose scores must be known before this is accepted."""
        if accepted is None or isinstance(accepted.score.hypothesis, ChangedParameter):
            return {*range(self.hypotheses.rows.n), None}
        return {accepted.score.hypothesis.axis}

    def scores_of(self, axis: Axis) -> list[Score]:
        """Of the effects of an axis beside the model."""
        return effect_scores(self.moments, self.hypotheses, self.known(), self.criteria, [axis])

    def chosen_of(self, scores: Sequence[Score], number: int) -> Accepted | None:
        """What is accepted of scores in a round."""

        @cache
        def plain() -> Moments:
            return self.moments.without(*(error for _, error in filter(None, self.terms)))

        def plainly(score: Score) -> Score:
            if not isinstance(score.hypothesis, EffectHypothesis):
                return score
            return with_shape(plain(), self.hypotheses, score)

        bars, pairs = self.bars, list(zip(self.known(), self.terms, strict=True))
        if pairs:
            blur = Blur(self.moments, plain, self.hypotheses, pairs, self.criteria)
            bars = replace(bars, blur=blur)
        least = unrepeated(self.moments.without(*self.answered), self.known())
        while True:
            accepted = chosen(least, self.known(), scores, bars, number, self.criteria, plainly)
            if accepted is None or self.determined(accepted.score):
                return accepted
            scores = [score for score in scores if score is not accepted.score]

    def determined(self, score: Score) -> bool:
        """Whether the runs, not noise, determine a model with it, and no wave is made by chance."""
        if not self.hypotheses.seen.clear(self.moments, score.hypothesis, score.order):
            return False
        if isinstance(score.hypothesis, Payload) or not _sure(self.moments, self.terms):
            return True
        longer, terms = self._with(score)
        self.longer = self.moments, score, longer, terms
        return _sure(longer, [*self.terms, terms])

    def _with(self, score: Score, *terms: Term) -> tuple[Moments, tuple[Term, ...]]:
        """The model with a hypothesis; terms: of the same effect before, whose products with others
        are known."""
        hypothesis = score.hypothesis
        if isinstance(hypothesis, ChangedParameter):
            return self.moments.loosened(hypothesis.places, self.criteria.loose**-2.0), ()
        terms = terms or self._terms(score)
        return reduce(Moments.extended, terms, self.moments), terms

    def own(self, axis: Axis) -> list[tuple[Score, tuple[Term, ...]]]:
        """Effects that were accepted on an axis."""
        pairs = zip(self.accepted, self.terms, strict=True)
        return [(a.score, t) for a, t in pairs if t and a.score.hypothesis.axis == axis]

    def judged(self) -> list[Accepted]:
        """What was accepted, with how exact the forms of effects are beside it."""
        pairs = zip(self.accepted, self.terms, strict=True)
        return [replace(a, inexact=inexact(self.moments, t[1])) if t else a for a, t in pairs]

    def known(self) -> list[Score]:
        """Scores of what was accepted."""
        return [each.score for each in self.accepted]

    def accept(self, accepted: Accepted, place: int | None = None, *terms: Term) -> None:
        """Put a hypothesis into the model, at a place of the list or at its end; terms: of the same
        effect before, whose products with others are known."""
        if self.longer and self.longer[:2] == (self.moments, accepted.score):
            self.moments, terms = self.longer[2:]
        else:
            self.moments, terms = self._with(accepted.score, *terms)
        self.longer, self.stale = None, self._against(None)
        place = len(self.accepted) if place is None else place
        self.accepted.insert(place, accepted)
        self.terms.insert(place, terms)
        pairs = [(t[0], t[1]) for t in self.terms if t]
        self.moments = limited(self.moments, pairs, self.criteria.form_error)

    def _terms(self, score: Score) -> tuple[Term, Term]:
        """An effect, with how it turns over, and the error of its form."""
        term = effect_term(self.moments, self.hypotheses, score)
        term = blended_term(self.hypotheses, score, term, self._gains(term))
        gains = self._gains(term)
        arguments = LOADED if self.hypotheses.with_torque(score.hypothesis.id) else ARGUMENTS
        error = form_error(score, self.criteria)
        return term, form_errors(self.hypotheses.rows, term, gains, error, arguments)

    def _gains(self, term: Term) -> Array:
        """Of a term (k,) beside the model."""
        longer = self.moments.extended(term)
        return np.asarray(longer.fit(None).q[longer.place(term)])


def _sure(moments: Moments, terms: Sequence[tuple[Term, ...]]) -> bool:
    """Whether the runs determine a model without its errors of form: friction and what is nearly
    alike have some that noise alone moves, and are no less sure for that."""
    return moments.without(*(error for _, error in filter(None, terms))).fit(None).sure


def _wider(accepted: Accepted | None, listed: Sequence[Score]) -> set[Axis]:
    """Axes of effects that may be the cause of what would be accepted, but were scored beside an
    earlier model: those that gain more, if several axes feel them, and those that base parameters
    make up for on their own axis, so that this one feels them more."""
    if accepted is None:
        return set()
    axes, place = set[Axis](), accepted.score.hypothesis.axis
    for score in listed:
        if isinstance(own := score.hypothesis, EffectHypothesis):
            if score.gain > accepted.score.gain and own.felt[1:]:
                axes.add(own.axis)
            if place is not None and own.axis is not None and score.spread:
                more = score.spread[place] > score.spread[own.axis]
                axes |= {own.axis} if more else set()
    return axes
