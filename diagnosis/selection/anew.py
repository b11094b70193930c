"""What was accepted, chosen anew beside what was found later.

An effect is accepted in a model in which others are still missing: its shape may stand for theirs,
too, or it may stand in for two.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from flexhex.diagnosis.selection.bars import form_error
from flexhex.diagnosis.selection.before import better_of, with_rivals_of
from flexhex.diagnosis.selection.changed import Axis
from flexhex.diagnosis.selection.choose import as_good, best_first, parameter_scores
from flexhex.diagnosis.selection.evidence import together, tried
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis, Hypothesis
from flexhex.diagnosis.selection.lookalike import beside_lookalike
from flexhex.diagnosis.selection.reshape import reshaped
from flexhex.diagnosis.selection.scores import with_shape
from flexhex.diagnosis.selection.search import Search


def revise(search: Search, latest: Hypothesis) -> None:
    """Move the shapes of effects of the axes that feel the latest one to where they are beside it,
    and choose those anew from which it took what they gain."""
    felt: set[Axis] = {latest.axis}
    if latest.axis is None:
        felt |= {*range(search.hypotheses.rows.n)}
    elif isinstance(latest, EffectHypothesis):
        felt |= {*latest.felt}
    reshape(search, felt)
    for _ in range(len(search.accepted)):
        names = [score.hypothesis.id for score in search.known()]
        for k in reversed(range(len(search.accepted) - 1)):
            if search.accepted[k].score.hypothesis.axis in felt and not _stands(search, k):
                choose_anew(search, k)
        if names == [score.hypothesis.id for score in search.known()]:
            break


def reshape(search: Search, felt: Collection[Axis]) -> None:
    """Move the shapes of effects of these axes, but for the latest one, to where they are beside
    the others, each if it then has more evidence."""
    known = {
        k: (search.accepted[k].score, terms[0])
        for k, terms in enumerate(search.terms[:-1])
        if terms and search.accepted[k].score.hypothesis.axis in felt
    }
    for k, effect in reshaped(search.moments, search.hypotheses, known, search.criteria).items():
        before = search.moments
        one, terms = search.accepted.pop(k), search.terms.pop(k)
        search.moments = before.without(*terms)
        own = [score.hypothesis.id for score, _ in search.own(effect.axis)]
        # a shape is chosen beside what it may look like, when it is found and when it moves
        beside = beside_lookalike(search.moments, search.hypotheses, effect, own)
        both = search.hypotheses.shaped(effect, one.score.effect[2], *effect.shapes)
        now, then = tried(beside, both, [None])[None].evidence
        if then > now:
            moved = replace(one.score, hypothesis=effect, shape=0)
            moved = with_shape(search.moments, search.hypotheses, moved)
            if search.determined(moved):
                search.accept(replace(one, score=moved), k)
                continue
        search.accepted.insert(k, one)
        search.terms.insert(k, terms)
        search.moments = before


def review(search: Search) -> None:
    """Choose all effects anew, each beside all others, where a form and its fuller one predict
    nearly alike: the fuller one may have made up for what was not in the model yet."""
    if any(set(each.fuller) & set(each.rivals) for each in search.accepted):
        for place in reversed(range(len(search.terms))):
            if search.terms[place]:
                choose_anew(search, place)


def choose_anew(search: Search, place: int) -> None:
    """Choose what takes an effect's place beside all others: it, another one or nothing."""
    before, terms = search.accepted.pop(place), search.terms.pop(place)
    search.moments = search.moments.without(*terms)
    changes = parameter_scores(search.moments, search.hypotheses, search.criteria)
    own, earlier = search.scores_of(before.score.hypothesis.axis), (before.score, *before.rivals)
    own = better_of(search.moments, search.hypotheses, own, earlier)
    scores = best_first([*changes, *own])
    accepted = search.chosen_of(scores, before.round)
    if accepted is None:
        return
    again = accepted.score.effect == before.score.effect
    accepted = with_rivals_of(before, accepted, scores, search.criteria)
    search.accept(accepted, place, *(terms if again else ()))


def _stands(search: Search, place: int) -> bool:
    """Whether an effect still gains what it gained when it was accepted; a parameter does."""
    score, terms = search.accepted[place].score, search.terms[place]
    if not terms:
        return True
    gain = together(search.moments, terms)
    return as_good(gain, score.gain, form_error(score, search.criteria), search.criteria)
