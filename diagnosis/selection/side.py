"""A selection as one side of the answer: joint fit, names, what remains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

from flexhex.diagnosis.answer import Joint, joint
from flexhex.diagnosis.blocks import JUDGED, Run, blocks
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.changed import changed_of
from flexhex.diagnosis.elsewhere import Elsewhere
from flexhex.diagnosis.found import Found, Part
from flexhex.diagnosis.guard import poor_axes, sentence
from flexhex.diagnosis.naming import named_of
from flexhex.diagnosis.selection.choose import Accepted, Selection, select, shown
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.hypotheses import ChangedParameter, EffectHypothesis
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.verdict import Candidate, Changed, Named

Say = Callable[[str], None]
SHOWN = 8
"""Candidates of a round that the page shows."""


@dataclass(frozen=True)
class Side:
    """One place where model and data meet: what was found there, and what remains (axes from 0)."""

    held: Joint
    others: Elsewhere | None
    named: tuple[Named, ...]
    changed: tuple[Changed, ...] = ()
    remains: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    candidates: tuple[Candidate, ...] = ()

    @property
    def matters(self) -> bool:
        """Whether anything was found or is left here."""
        return bool(self.named or self.remains)


def selected(
    bench: Bench,
    judged: Sequence[Run],
    say: Say,
    drift: Joint | None = None,
    criteria: Criteria = USUAL,
) -> Side:
    """What explains the runs beside a base model.

    judged: held-out runs, which decide nothing; drift: what was taken off the runs before.
    """
    made, notes = bench.made, list[str]()
    selection = select(bench, criteria, say)
    kept = [a for a in selection.accepted if isinstance(a.score.hypothesis, EffectHypothesis)]
    if kept and not selection.arbitrated:
        listed = ", ".join(dict.fromkeys(a.score.hypothesis.id for a in kept))
        notes.append(f"{listed} would fit, but nothing shows it on another trajectory: record one")
        kept = []
    remains = nameless(selection, criteria)
    for axis, open_ in remains.items():
        own = [a for a in kept if a.score.hypothesis.axis == axis]
        torque = f"{open_.size * made.torque_rms[axis]:.2g} N m on axis {axis + 1} repeats"
        share = open_.size / max(sum(a.score.size**2 for a in own) ** 0.5, 1e-12)
        if share > criteria.largest_rest:
            kept = [a for a in kept if a not in own]
            notes.append(f"{torque} and is explained by no effect of the library{open_.what}")
        else:
            notes.append(f"{torque}, {share:.0%} of what was found: its form is not exact")
    bodies = [
        a.score.hypothesis.places
        for a in selection.accepted
        if isinstance(a.score.hypothesis, ChangedParameter)
    ]
    freed = {place: criteria.loose**-2.0 for body in bodies for place in body}
    held = joint(bench, grouped(bench, kept), freed)
    poor = poor_axes(made, held.residual)
    if poor:
        kept = [a for a in kept if a.score.hypothesis.axis not in poor]
        held = joint(bench, grouped(bench, kept), freed)
        notes.append(sentence(poor))
    others = None
    if judged:
        others = Elsewhere(bench, blocks(made.base, judged, made.spacing, JUDGED), drift)
    named = {a.score.hypothesis.axis for a in kept}
    return Side(
        held,
        others,
        tuple(named_of(held)),
        tuple(changed_of(held, bodies)),
        tuple(axis for axis in sorted({*remains, *poor}) if axis not in named),
        tuple(notes),
        tuple(_candidates(selection)),
    )


@dataclass(frozen=True)
class Nameless:
    """Something without a name: relative RMS; what it goes with, as a phrase, where that is
    known."""

    size: float
    what: str = ""


def nameless(selection: Selection, criteria: Criteria) -> dict[int, Nameless]:
    """Axes on which something without a name is left: smooth in the motion, or of any other form as
    long as it repeats. On one trajectory alone only what repeats counts."""
    left = selection.rest if selection.arbitrated else selection.before
    found = {k: Nameless(rest.size) for k, rest in enumerate(left) if rest.matters(criteria)}
    if not selection.arbitrated:
        return found
    least = log(len(selection.beside) / criteria.false_alarms)
    for axis, score in enumerate(selection.beside):
        large = score.size > criteria.smallest_rest
        if large and score.gain > least and shown(score, criteria):
            size = max(score.size, found[axis].size if axis in found else 0.0)
            found[axis] = Nameless(size, f": it goes with {score.hypothesis.id}")
    return found


def grouped(bench: Bench, accepted: Sequence[Accepted]) -> list[Found]:
    """Accepted effects of one kind on several axes as one."""
    parts: dict[str, list[Part]] = {}
    rivals: dict[str, list[str]] = {}
    for each in accepted:
        hypothesis = each.score.hypothesis
        assert isinstance(hypothesis, EffectHypothesis)
        shape = dict(hypothesis.shapes[each.score.shape])
        part = Part.of(bench, hypothesis.id, hypothesis.axis, shape, each.score.still)
        parts.setdefault(hypothesis.id, []).append(part)
        others = [r.hypothesis for r in each.rivals]
        listed = [o.id for o in others if isinstance(o, EffectHypothesis)]
        rivals.setdefault(hypothesis.id, []).extend(listed)
    return [Found(name, tuple(p), tuple(dict.fromkeys(rivals[name]))) for name, p in parts.items()]


def _candidates(selection: Selection) -> list[Candidate]:
    """The best hypotheses of every round, and which of them was accepted."""
    found = []
    for number, scores in enumerate(selection.rounds, start=1):
        chosen = selection.accepted[number - 1] if number <= len(selection.accepted) else None
        same = () if chosen is None else (chosen.score, *chosen.rivals)
        for score in [*same, *(s for s in scores if s not in same)][:SHOWN]:
            first = chosen is not None and score is chosen.score
            found.append(_candidate(number, score, first, score in same and not first))
    return found


def _candidate(number: int, score: Score, chosen: bool, rival: bool) -> Candidate:
    hypothesis = score.hypothesis
    shapes = hypothesis.shapes if isinstance(hypothesis, EffectHypothesis) else ()
    shape = dict(shapes[score.shape]) if shapes else {}
    axes = () if hypothesis.axis is None else (hypothesis.axis + 1,)
    return Candidate(number, hypothesis.id, axes, shape, score.gain, score.size, chosen, rival)
