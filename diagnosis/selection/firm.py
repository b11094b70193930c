"""What stands beside all that is named: an effect whose gains may be zero there has no name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.diagnosis.selection.bars import form_error
from flexhex.diagnosis.selection.changed import Axis
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.form import mean_error
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score

Array = NDArray[np.float64]


def firm(
    bench: Bench,
    accepted: Sequence[Accepted],
    criteria: Criteria,
    freed: Mapping[int, float] = MappingProxyType({}),
    listed: Iterable[Score] = (),
) -> tuple[list[Accepted], Joint]:
    """Accepted effects without those whose gains do not stand above zero in the fit of all, the
    least certain one first; and that fit.

    A search takes effects one after the other, in a model that is still wrong elsewhere. Errors of
    the last fit are those of its own residual, whatever that is made of. Gains that cannot be
    negative are not negative there either: they are held at zero, the clearest one first. An effect
    with one gain alone, or whose further gains do not stand above zero, is the simpler one that it
    extends, if that is among those `listed`; one without any gain goes.
    """
    simpler = {(s.hypothesis.id, s.hypothesis.axis): s for s in listed}
    kept = list(accepted)
    while True:
        fit = joint(bench, grouped(bench, kept), freed)
        order = ordered(kept)
        below = [
            _below(each, *own) for each, *own in zip(order, fit.beta, fit.deviation, strict=True)
        ]
        if max((size for size, _ in below), default=0.0) > 0:
            worst = max(range(len(order)), key=lambda k: below[k][0])
            surely = below[worst][0] > NORMAL
            kept = _held(kept, order[worst], below[worst][1], simpler, surely)
        elif min(fit.sure, default=np.inf) < criteria.deviations:
            kept.remove(order[int(np.argmin(fit.sure))])
        elif plain := _plain(order, fit.further, simpler, criteria):
            kept = [_in_place(*plain) if each is plain[0] else each for each in kept]
        else:
            return kept, fit


def _plain(
    order: Sequence[Accepted],
    further: Sequence[float],
    simpler: Mapping[tuple[str, Axis], Score],
    criteria: Criteria,
) -> tuple[Accepted, Score] | None:
    """The effect whose further gains are least certain, and the simpler one that it extends."""
    pairs = zip(further, order, strict=True)
    for sure, each in sorted(pairs, key=lambda pair: pair[0]):
        part = simpler.get((_effect(each).extends, _effect(each).axis))
        if sure < criteria.deviations and part is not None:
            return each, part
    return None


def _in_place(one: Accepted, part: Score, surely: bool = False) -> Accepted:
    """A simpler effect in the place of one that extends it, which the search has chosen: so that
    remains its rival, unless it is `surely` no more than the simpler one."""
    others = [r for r in one.rivals if r.hypothesis.id != part.hypothesis.id]
    rivals = others if surely else [one.score, *others]
    return replace(one, score=part, rivals=tuple(rivals), fuller=())


def _below(accepted: Accepted, gains: Array, deviation: Array) -> tuple[float, int]:
    """How far the gain (k,) that is most surely negative lies below zero, in deviations, of those
    that cannot be; and its place."""
    free = (_effect(accepted).low == 0) & (deviation > 0) & np.isfinite(deviation)
    sure = np.divide(-gains, deviation, where=free, out=np.zeros(len(gains)))
    place = int(np.argmax(sure))
    return float(sure[place]), place


def _held(
    kept: Sequence[Accepted],
    one: Accepted,
    place: int,
    simpler: Mapping[tuple[str, Axis], Score],
    surely: bool,
) -> list[Accepted]:
    """The same with a gain of one of them held at zero, below which it `surely` is."""
    effect, still = _effect(one), {*one.score.still, place}
    part = simpler.get((effect.extends, effect.axis))
    fewer = replace(one, score=replace(one.score, still=tuple(sorted(still))))
    if part is not None and still == {*range(1, effect.width)}:
        fewer = _in_place(one, part, surely)
    left = [fewer if each is one else each for each in kept]
    return [each for each in left if len(each.score.still) < _effect(each).width]


def grouped(bench: Bench, accepted: Sequence[Accepted]) -> list[SelectedEffect]:
    """Accepted effects of one kind on several axes as one."""
    effects = []
    for name, same in _by_effect(accepted).items():
        parts = list[Part]()
        for each in same:
            hypothesis = _effect(each)
            shape = dict(hypothesis.shapes[each.score.shape])
            others = (rival.hypothesis for rival in each.rivals)
            rivals = [other.id for other in others if isinstance(other, EffectHypothesis)]
            alike = tuple(dict.fromkeys(rivals))
            parts.append(Part.of(bench, name, hypothesis.axis, shape, each.score.still, alike))
        effects.append(SelectedEffect(name, tuple(parts)))
    return effects


def errors_of(accepted: Sequence[Accepted], criteria: Criteria) -> list[float]:
    """What the error of its form does to the gains of each part of these effects, relative, one
    standard deviation; in the order of `grouped`."""
    listed = ordered(accepted)
    return [mean_error(form_error(each.score, criteria) * each.inexact) for each in listed]


def without_name(accepted: Sequence[Accepted]) -> set[int]:
    """Places of the parts, in the order of `grouped`, that get no name."""
    return {k for k, each in enumerate(ordered(accepted)) if not each.named}


def ordered(accepted: Sequence[Accepted]) -> list[Accepted]:
    """In the order of the parts of `grouped`."""
    return [each for same in _by_effect(accepted).values() for each in same]


def _by_effect(accepted: Sequence[Accepted]) -> dict[str, list[Accepted]]:
    """By the id of the effect, each by axis."""
    groups: dict[str, list[Accepted]] = {}
    for each in sorted(accepted, key=lambda a: a.score.hypothesis.axis or 0):
        groups.setdefault(_effect(each).id, []).append(each)
    return groups


def _effect(accepted: Accepted) -> EffectHypothesis:
    hypothesis = accepted.score.hypothesis
    assert isinstance(hypothesis, EffectHypothesis)
    return hypothesis
