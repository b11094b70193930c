"""A selection as one side of the answer: joint fit, names, what remains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import log

from flexhex.diagnosis.answer import Joint, joint
from flexhex.diagnosis.blocks import JUDGED, Run, blocks
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.naming import named_of
from flexhex.diagnosis.regression import Columns
from flexhex.diagnosis.rounds import Round
from flexhex.diagnosis.scored import Found, Scored
from flexhex.diagnosis.selection.choose import Accepted, Selection, form_error, select
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.hypotheses import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.sides import Side
from flexhex.diagnosis.unannounced import elsewhere, payload_changes

Say = Callable[[str], None]


def selected(
    bench: Bench,
    judged: Sequence[Run],
    say: Say,
    least: float = 0.0,
    drift: Joint | None = None,
    criteria: Criteria = USUAL,
) -> Side:
    """What explains the runs, as `flexhex.diagnosis.sides.side_of` says it.

    least: not asked, the criteria have a smallest effect for all places alike.
    """
    selection = select(bench, criteria, say)
    bench, notes = selection.bench, list[str]()
    made = bench.made
    kept = [a for a in selection.accepted if isinstance(a.score.hypothesis, EffectHypothesis)]
    if kept and not selection.arbitrated:
        listed = ", ".join(dict.fromkeys(a.score.hypothesis.id for a in kept))
        notes.append(f"{listed} would fit, but nothing shows it on another trajectory: record one")
        kept = []
    remains = nameless(selection, criteria)
    for axis, size in remains.items():
        own = [a for a in kept if a.score.hypothesis.axis == axis]
        torque = f"{size * made.torque_rms[axis]:.2g} N m on axis {axis + 1} repeats"
        if sum(a.score.size**2 for a in own) < size**2:
            kept = [a for a in kept if a not in own]
            notes.append(f"{torque} and is explained by no effect of the library")
        else:
            notes.append(f"{torque} beside what was found: the form of that is not exact")
    open_axes = [k for k in remains if not any(a.score.hypothesis.axis == k for a in kept)]
    held = joint(bench, grouped(bench, kept))
    payloads = payload_changes(held)
    if payloads and not selection.arbitrated:
        notes.append("the payload shows on one trajectory only: record it on another one")
    others = None
    if judged:
        others = elsewhere(held, blocks(made.base, judged, made.spacing, JUDGED), drift)
    rounds = _rounds(bench, selection)
    return Side(
        held,
        tuple(rounds),
        others,
        tuple(named_of(held, rounds)),
        tuple(open_axes),
        tuple(notes),
        tuple(payloads),
    )


def nameless(selection: Selection, criteria: Criteria) -> dict[int, float]:
    """Axes on which something without a name is left, with its relative RMS: smooth in the motion,
    or of any other form as long as it repeats.

    Where a smooth function predicts better than all that was accepted, that is an imitation. On one
    trajectory alone only what repeats counts.
    """
    left = selection.rest if selection.arbitrated else selection.before
    found = {k: rest.size for k, rest in enumerate(left) if rest.matters(criteria)}
    if not selection.arbitrated:
        return found
    for axis, (alone, beside) in enumerate(zip(selection.alone, selection.beside, strict=True)):
        own = [a.score for a in selection.accepted if a.score.hypothesis.axis == axis]
        gain = sum(score.gain for score in own)
        error = max((form_error(score, criteria) for score in own), default=0.0)
        better = alone.gain - gain > log(criteria.odds) + error**2 * gain
        for score, counts in (
            (alone, better),
            (beside, beside.gain > log(1 / criteria.false_alarms)),
        ):
            if counts and score.size > criteria.smallest_rest:
                found[axis] = max(found.get(axis, 0.0), score.size)
    return found


def grouped(bench: Bench, accepted: Sequence[Accepted]) -> list[Found]:
    """Accepted effects of one kind on several axes as one."""
    parts: dict[str, list[Scored]] = {}
    rivals: dict[str, list[str]] = {}
    for each in accepted:
        name = each.score.hypothesis.id
        parts.setdefault(name, []).append(part_of(bench, each.score))
        others = [r.hypothesis for r in each.rivals]
        rivals.setdefault(name, []).extend(o.id for o in others if isinstance(o, EffectHypothesis))
    return [Found(name, tuple(p), tuple(dict.fromkeys(rivals[name]))) for name, p in parts.items()]


def part_of(bench: Bench, score: Score) -> Scored:
    """A scored effect with its columns."""
    hypothesis = score.hypothesis
    assert isinstance(hypothesis, EffectHypothesis)
    shape = dict(hypothesis.shapes[score.shape])
    columns = bench.columns(hypothesis.id, hypothesis.axis or 0, shape)
    if hypothesis.axis is None:
        columns = Columns(None, columns.values)
    gain = bench.made.regression.gain(columns)
    return Scored(hypothesis.id, hypothesis.axis, shape, gain, columns)


def _rounds(bench: Bench, selection: Selection) -> list[Round]:
    """Rounds as the page shows them."""
    found = []
    for number, scores in enumerate(selection.rounds):
        chosen = selection.accepted[number] if number < len(selection.accepted) else None
        best: dict[str, Score] = {}
        for score in scores:
            if isinstance(score.hypothesis, EffectHypothesis):
                best.setdefault(score.hypothesis.id, score)
        total = max(max(rest.size for rest in selection.before) ** 2, 1e-300)
        tried = tuple(Found(name, (part_of(bench, s),), ()) for name, s in list(best.items())[:4])
        shares = {name: float(s.size**2 / total) for name, s in best.items()}
        named = None
        if chosen is not None and isinstance(chosen.score.hypothesis, EffectHypothesis):
            (named,) = grouped(bench, [chosen])
        found.append(Round(tried, shares, named))
    return found
