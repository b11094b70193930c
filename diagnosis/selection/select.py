"""The selection on a base model: hypotheses accepted one after the other, payloads first.

    y = B q + accepted terms + what is asked for + noise

Every hypothesis answers the same question: how much better does it predict trajectories that it was
not fitted to, and how large is it?
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from gc import collect

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.selection.anew import review, revise
from flexhex.diagnosis.selection.bars import bars_of, passes
from flexhex.diagnosis.selection.changed import ChangedParameter, HeavierBody
from flexhex.diagnosis.selection.choose import Accepted, one_cause
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.feedback import repeating
from flexhex.diagnosis.selection.heavier import heavier, moved_gain
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis, Payload
from flexhex.diagnosis.selection.imitated import Imitated, imitated, surely_beside
from flexhex.diagnosis.selection.left import Rest, explained, rest_of
from flexhex.diagnosis.selection.parts import with_wholes
from flexhex.diagnosis.selection.payload import payload_score
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.search import Search

Say = Callable[[str], None]


@dataclass(frozen=True)
class Selection:
    """What was chosen, in its order; what is left on each axis, before and after; all scores of
    every round.

    explained: relative RMS, on each axis, of the torque of all effects together beyond what the
    base model takes up. arbitrated: there was another trajectory to predict. bench: of the base
    model with the payloads that were found. search: as it ended; columns that it needs are made
    again. moved: what parameters gain that are not the machine file's [nats].
    """

    accepted: tuple[Accepted, ...]
    explained: tuple[float, ...]
    arbitrated: bool
    before: tuple[Rest, ...]
    rest: tuple[Rest, ...]
    rounds: tuple[tuple[Score, ...], ...]
    bench: Bench
    search: Search
    moved: float = 0.0

    @cached_property
    def imitated(self) -> tuple[Imitated, ...]:
        """Of each axis what has no name, beside and in the place of what was accepted; computed
        when asked for: of most searches nobody does."""
        return tuple(imitated(self.search, axis) for axis in range(self.bench.n))

    def placed(self, accepted: Accepted) -> bool:
        """Whether an effect goes with the angle of its axis alone."""
        return self.search.hypotheses.with_angle(accepted.score.hypothesis.id)

    def imitates(self, accepted: Accepted) -> bool:
        """Whether an effect of an axis may only imitate something that has no name."""
        axis = accepted.score.hypothesis.axis
        if axis is None:
            return False
        # the search may know it by another name; what came in its place later it does not know
        own = [each for each in self.effects if each.score.hypothesis.axis == axis]
        place = next((k for k, each in enumerate(own) if each is accepted), None)
        beside = self.imitated[axis].beside
        return place is None or not surely_beside(self.search, axis, place, beside)

    @property
    def effects(self) -> list[Accepted]:
        """Those of the library that were accepted."""
        return [a for a in self.accepted if isinstance(a.score.hypothesis, EffectHypothesis)]

    @property
    def moved_places(self) -> list[tuple[int, ...]]:
        """Places of the parameters that left their tolerances, of each hypothesis."""
        hypotheses = (accepted.score.hypothesis for accepted in self.accepted)
        return [h.places for h in hypotheses if isinstance(h, ChangedParameter)]

    def freed(self, criteria: Criteria) -> dict[int, float]:
        """Inverse variances of all these, as loose as they may be."""
        return {place: criteria.loose**-2.0 for body in self.moved_places for place in body}


def select(bench: Bench, criteria: Criteria = USUAL, say: Say = lambda text: None) -> Selection:
    """Accept hypotheses until none gains enough on left-out trajectories.

    With a payload all begins anew: what was accepted without it may have taken its place.
    """
    while True:
        selection = _selected(bench, criteria, say)
        if isinstance(selection, Selection):
            return selection
        bench = selection


def _selected(bench: Bench, criteria: Criteria, say: Say) -> Selection | Bench:
    """The same beside a base model, or the base model with a payload that was found on the way."""
    # those of a search before: they and what makes their columns refer to each other
    collect()
    hypotheses = Hypotheses(bench, Rows.of(bench.model))
    search = Search(hypotheses, criteria)
    before = rest_of(search.moments)
    rounds = list[tuple[Score, ...]]()
    while len(rounds) < 2 * criteria.most * bench.n:
        say(f"effects, round {len(rounds) + 1}")
        accepted, scores = search.next(len(rounds) + 1)
        rounds.append(tuple(scores))
        if accepted is None:
            break
        if isinstance(accepted.score.hypothesis, Payload):
            return accepted.score.hypothesis.bench
        if isinstance(accepted.score.hypothesis, HeavierBody):
            return heavier(bench, accepted.score.hypothesis, search.moments)
        search.accept(accepted)
        revise(search, accepted.score.hypothesis)
    review(search)
    arbitrated = len({block.run.trajectory for block in bench.model.blocks}) > 1
    moments = search.moments
    moved = [
        score.gain * moments.rows.often(score.hypothesis.places)
        for score in search.known()
        if isinstance(score.hypothesis, ChangedParameter)
    ]
    hypotheses.forget()
    return Selection(
        tuple(one_cause(with_wholes(search.judged(), criteria))),
        explained(hypotheses.moments, moments, criteria),
        arbitrated,
        before,
        _rest(search),
        tuple(rounds),
        bench,
        search,
        moved_gain(moments) + sum(moved),
    )


def _rest(search: Search) -> tuple[Rest, ...]:
    """What is left of each axis; where nothing was accepted on it, with what was taken for an
    answer of feedback to noise, if that repeats."""
    rest, moments = rest_of(search.moments), search.moments
    if not search.answered:
        return rest
    named = {a.score.hypothesis.axis for a in search.accepted}
    with_answers = rest_of(moments.without(*search.answered))
    mechanism = repeating(moments, search.answered)
    return tuple(
        with_answers[i] if mechanism[i] and i not in named else own for i, own in enumerate(rest)
    )


def carrying(bench: Bench, criteria: Criteria = USUAL) -> Bench:
    """The same beside a payload, if the runs show one before any effect is known."""
    hypotheses = Hypotheses(bench, Rows.of(bench.model))
    score = payload_score(hypotheses.moments, hypotheses, (), criteria)
    if score is None or not passes(score, (), bars_of(hypotheses, criteria), criteria):
        return bench
    assert isinstance(score.hypothesis, Payload)
    return score.hypothesis.bench
