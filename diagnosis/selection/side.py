"""A selection as one side of the answer: joint fit, names, what remains."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.jointfit.guard import poor_axes, sentence
from flexhex.diagnosis.result.changed import changed_of, impossible, payload_changes
from flexhex.diagnosis.result.naming import (
    faint_parts,
    named_of,
    unnamed_parts,
    usual_parts,
    widened,
)
from flexhex.diagnosis.result.pictured import Candidate
from flexhex.diagnosis.result.rest import REFUTED, TOO_LARGE, UNCONFIRMED, UNSURE, Rest
from flexhex.diagnosis.result.verdict import Changed, Named
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.faint import with_faint
from flexhex.diagnosis.selection.firm import errors_of, firm, ordered, without_name
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.nameless import Nameless, nameless, tolerated
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.select import Selection
from flexhex.diagnosis.selection.unrefuted import Fitted, placed, said_of, unrefuted
from flexhex.diagnosis.selection.validated import validated

Say = Callable[[str], None]
SHOWN = 8
"""Candidates of a round that the page shows."""
LITTLE = 0.01
"""Share of what repeats that is no explanation."""


@dataclass(frozen=True)
class Side:
    """One place where model and data meet: what was found there, and what remains (axes from 0).

    unconfirmed: an effect would fit, but there is no other trajectory that could show it. refuted:
    so would other parameters than the machine file's, but held-out runs become worse with them.
    """

    fit: Joint
    others: Elsewhere | None
    named: tuple[Named, ...]
    changed: tuple[Changed, ...] = ()
    remains: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    candidates: tuple[Candidate, ...] = ()
    rests: tuple[Rest, ...] = ()
    unconfirmed: bool = False
    refuted: bool = False

    @property
    def matters(self) -> bool:
        """Whether anything was found or is left here."""
        return bool(self.named or self.remains)


def side_of(
    selection: Selection,
    others: Elsewhere | None,
    refuting: Elsewhere | None,
    criteria: Criteria,
) -> Side:
    """What of a selection has a name beside held-out runs, and what remains; refuting: those of
    motions that were not fitted."""
    bench, notes = selection.bench, list[str]()
    model, moved, effects = bench.model, selection.moved_places, selection.effects
    why, kept = "", effects
    freed = selection.freed(criteria)
    if not selection.arbitrated or (refuting is not None and not model.noise.repeats):
        kept = validated(bench, effects, refuting, criteria, selection.rounds, freed)
        why = REFUTED if selection.arbitrated or kept else UNCONFIRMED
    lost = [a for a in effects if a not in kept]
    remains = nameless(selection, criteria, {a.score.hypothesis.axis for a in kept})
    kept, rests, told = _rests(bench, selection, remains, kept, (lost, why), criteria)
    notes += told
    # where nothing has a name, parameters only imitate what is left, if it is not small beside them
    left_over = sum(left.gain for left in remains.values())
    minor = left_over <= criteria.largest_rest**2 * selection.moved
    bodies = moved if minor or any(a.named for a in kept) else []
    freed = freed if bodies else {}
    listed = [score for scores in selection.rounds for score in scores]
    told_of = kept
    kept, fit = firm(bench, kept, criteria, freed, listed)
    poor = poor_axes(model, fit.residual)
    if poor:
        kept = [replace(a, named=False) if a.score.hypothesis.axis in poor else a for a in kept]
        kept, fit = firm(bench, kept, criteria, freed, listed)
        notes.append(sentence(poor))
    held = unrefuted(Fitted(kept, fit, bodies, freed), others, criteria, listed)
    kept, fit, bodies, refused = held.effects, held.fit, list(held.bodies), held.refused
    if held.refuted:
        notes.append("other parameters would fit, but the held-out runs become worse")
    # what was left beside effects that have no name now is all of it; of poor axes that is said
    bare = {r.axis - 1 for r in rests if r.beside} - {
        a.score.hypothesis.axis for a in kept if a.named
    }
    anew = {axis: remains[axis] for axis in bare if axis not in poor}
    rests = [r for r in rests if r.axis - 1 not in bare]
    rests += _rests(bench, selection, anew, kept, ([], ""), criteria)[1]
    unsure = _without_gains(selection, told_of, [*kept, *refused], {*remains, *poor}, criteria)
    denied = _without_gains(selection, refused, kept, {*remains, *poor}, criteria)
    rests += _rests(bench, selection, unsure, kept, (told_of, UNSURE), criteria)[1]
    rests += _rests(bench, selection, denied, kept, (refused, REFUTED), criteria)[1]
    remains |= unsure | denied
    notes += said_of([a for a in refused if a.score.hypothesis.axis not in denied])
    notes += [rest.sentence() for rest in rests]
    payloads = payload_changes(fit)
    if payloads and not selection.arbitrated:
        notes.append("the payload shows on one trajectory only: record it on another one")
    notes += [*usual_parts(fit), *unnamed_parts(fit, without_name(kept))]
    names = named_of(fit, errors_of(kept, criteria), without_name(kept))
    if fuller := with_faint(held, selection, criteria, listed):
        more, wider = fuller
        names = widened(names, named_of(wider, errors_of(more, criteria), without_name(more)))
        notes += faint_parts(wider, {k for k, a in enumerate(ordered(more)) if a.faint})
    named = {a.score.hypothesis.axis for a in kept if a.named}
    odd, changed = impossible(fit, bodies), changed_of(fit, bodies)
    unnamed = () if minor and changed else remains
    if odd:
        # something else is wrong, which all parameters together imitate
        changed, poor = [], list(range(model.base.n))
        text = "would have to be at or below zero: something else is wrong, no parameter is named"
        notes.append(f"{', '.join(odd)} {text}")
    return Side(
        fit,
        others,
        tuple(names),
        (*payloads, *changed),
        tuple(axis for axis in sorted({*unnamed, *poor}) if axis not in named),
        tuple(notes),
        tuple(_candidates(selection)),
        tuple(rests),
        bool(lost) and why == UNCONFIRMED,
        held.refuted,
    )


def _rests(
    bench: Bench,
    selection: Selection,
    remains: Mapping[int, Nameless],
    kept: Sequence[Accepted],
    refused: tuple[Sequence[Accepted], str],
    criteria: Criteria,
) -> tuple[list[Accepted], list[Rest], list[str]]:
    """What is kept beside what remains, that as it is told, and notes.

    refused: what other runs have not confirmed, and why.
    """
    model, rests, notes, (lost, why) = bench.model, list[Rest](), list[str](), refused
    kept = list(kept)
    for axis, left in remains.items():
        own = [a for a in kept if a.score.hypothesis.axis == axis]
        most = tolerated(own, selection.explained[axis], criteria)
        over = [k for k, size in enumerate(most) if left.size > size]
        only = [k for k in over if selection.imitates(own[k])]
        instead = [k for k, a in enumerate(own) if a in left.instead]
        doubtful = {*instead, *over}
        if len(doubtful) < len(own):
            # of what goes with the angle alone `nameless` has asked that already
            doubtful = {*instead, *(k for k in only if not selection.placed(own[k]))}
        elif left.what == "angle":
            # a function of the angle is no doubt of what is none, and surely stands beside it
            sure = [k for k in over if left.beyond <= most[k] and not selection.placed(own[k])]
            doubtful -= {*sure} - {*only, *instead}
        beside = len(doubtful) < len(own)
        # they stay in the fit, where others would stand in for them
        lose = [own[k] for k in doubtful]
        kept = [replace(a, named=False) if a in lose else a for a in kept]
        # what has no name here has no part in what is explained
        share = left.size if beside else left.whole
        size, unit = share * float(model.torque_rms[axis]), bench.scales.kinds[axis].unit("N m")
        told = unit, share, left.what, beside, beside and left.form
        rest = Rest(axis + 1, size, *told, repeats=model.noise.repeats)
        gone = [a for a in lost if a.score.hypothesis.axis == axis]
        unnamed = [] if beside else own or gone
        least = left.size if own else selection.rest[axis].size
        share = 1 - min(least / left.whole, 1.0) ** 2 if unnamed else 0.0
        if share > LITTLE:
            rest = replace(
                rest,
                fitted=tuple(dict.fromkeys(a.score.hypothesis.id for a in unnamed)),
                fitted_share=share,
                why=TOO_LARGE if own else why,
            )
            lost = [a for a in lost if a not in gone]
        rests.append(rest)
    if lost:
        names = ", ".join(dict.fromkeys(placed(a.score) for a in lost))
        notes.insert(0, f"{names} would fit, {why}")
    return kept, rests, notes


def _without_gains(
    selection: Selection,
    accepted: Sequence[Accepted],
    settled: Sequence[Accepted],
    said: Collection[int],
    criteria: Criteria,
) -> dict[int, Nameless]:
    """What repeats on axes of which no effect that was accepted is determined beside the others, so
    that none has a name; but for those of which that is settled otherwise, or said."""
    done = {a.score.hypothesis.axis for a in settled}
    axes = {axis for a in accepted if (axis := a.score.hypothesis.axis) is not None}
    alone = {axis: selection.before[axis] for axis in axes - done - {*said}}
    return {
        axis: Nameless(rest.size, rest.size, gain=rest.gain)
        for axis, rest in alone.items()
        if rest.deviations > criteria.deviations and rest.size > criteria.smallest_rest
    }


def _candidates(selection: Selection) -> list[Candidate]:
    """The best hypotheses of every round, and which of them was accepted."""
    candidates = []
    for number, scores in enumerate(selection.rounds, start=1):
        chosen = next((a for a in selection.accepted if a.round == number), None)
        same = () if chosen is None else (chosen.score, *chosen.rivals)
        for score in [*same, *(s for s in scores if s not in same)][:SHOWN]:
            first = chosen is not None and score is chosen.score
            candidates.append(_candidate(number, score, first, score in same and not first))
    return candidates


def _candidate(number: int, score: Score, chosen: bool, rival: bool) -> Candidate:
    hypothesis = score.hypothesis
    shapes = hypothesis.shapes if isinstance(hypothesis, EffectHypothesis) else ()
    shape = dict(shapes[score.shape]) if shapes else {}
    axes = () if hypothesis.axis is None else (hypothesis.axis + 1,)
    return Candidate(number, hypothesis.id, axes, shape, score.gain, score.size, chosen, rival)
