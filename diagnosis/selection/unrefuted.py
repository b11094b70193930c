"""Where held-out runs speak against what the others say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.result.verdict import WORSE
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.firm import firm
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.validated import Predicted, unpredicted

Array = NDArray[np.float64]
Bodies = Sequence[tuple[int, ...]]


@dataclass(frozen=True)
class Fitted:
    """Effects and their fit. bodies: places of the base parameters that are others than in the
    machine file, with the inverse variances `freed`; refused: effects that made held-out runs
    worse; refuted: parameters did, which are those of the machine file again."""

    effects: list[Accepted]
    fit: Joint
    bodies: Bodies
    freed: Mapping[int, float]
    refused: tuple[Accepted, ...] = ()
    refuted: bool = False


def unrefuted(
    now: Fitted, others: Elsewhere | None, criteria: Criteria, listed: Sequence[Score]
) -> Fitted:
    """What is kept of effects and changed parameters: those without which held-out runs do not
    become better; listed: all scores, of which one may take another's place."""
    while others is not None and (now.effects or now.freed):
        less = _less(now, others, criteria, listed)
        if less is None:
            break
        now = less
    return now


def _less(
    now: Fitted, others: Elsewhere, criteria: Criteria, listed: Sequence[Score]
) -> Fitted | None:
    """The same without what these runs refute first: the effect that they support least, unless
    they support all that are there and other parameters are in doubt. None if that is nothing."""
    bench, (worse, whole) = now.fit.bench, refuted(now.fit, others)
    there = [a for a in now.effects if a.score.hypothesis.axis in worse]
    seen = Predicted(bench, others, criteria, now.freed)
    margins = [seen.margin(a, [b for b in now.effects if b is not a]) for a in there]
    if there and (min(margins) <= 0 or not now.freed):
        wrong = there[int(np.argmin(margins))]
        left = [a for a in now.effects if a is not wrong]
        effects, fit = firm(bench, left, criteria, now.freed, listed)
        return replace(now, effects=effects, fit=fit, refused=(*now.refused, wrong))
    if not now.freed:
        return None
    effects, fit = firm(bench, now.effects, criteria, {}, listed)
    if not whole and better(now.fit, fit, others, WORSE):
        return None
    return Fitted(effects, fit, (), {}, now.refused, refuted=True)


def said_of(refused: Sequence[Accepted]) -> list[str]:
    """A note on effects that made held-out runs worse."""
    names = ", ".join(dict.fromkeys(placed(a.score) for a in refused))
    return [f"{names} would fit, but the held-out runs become worse"] if refused else []


def placed(score: Score) -> str:
    """An effect and its axis in words."""
    axis = score.hypothesis.axis
    return score.hypothesis.id + ("" if axis is None else f" on axis {axis + 1}")


def refuted(fit: Joint, others: Elsewhere) -> tuple[list[int], bool]:
    """Axes (from 0) of which a fit leaves more on held-out runs than the base model's own does, and
    whether it does of all together, noise apart."""
    own, now = _left_of_base(fit, others), _left(fit, others)
    before, after = (axis_rms(others.blocks, left) for left in (own, now))
    worse = [int(i) for i in np.flatnonzero(after > WORSE * before)]
    return worse, _all(fit, others, now) > WORSE * _all(fit, others, own)


def better(fit: Joint, without: Joint, others: Elsewhere, times: float = 1.0) -> bool:
    """Whether a fit leaves less of the held-out runs, on all axes together, than so many times what
    one without some of its parameters does: that their tolerances do not hold them hardly shows
    there."""
    left, most = (_all(one, others, _left(one, others)) for one in (fit, without))
    return left < times * most


def _left(fit: Joint, others: Elsewhere) -> list[Array]:
    """What a fit leaves on held-out runs (m, n) [N m] of each block."""
    return others.residual(fit.parts, fit.beta, fit.q)


def _left_of_base(fit: Joint, others: Elsewhere) -> list[Array]:
    """The same of the base model's own fit."""
    return others.residual((), (), fit.bench.model.regression.q)


def _all(fit: Joint, others: Elsewhere, left: Sequence[Array]) -> float:
    """What is left of all axes together, each relative to its torque."""
    size = unpredicted(others.there, left) / fit.bench.model.torque_rms
    return float(np.linalg.norm(size))
