"""Effects that the model's file states, beside what the runs show: the search finds them as it
finds all others. One that comes out as the file has it is no finding; another value is a change."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.extras import Extra
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.kinds import axes_named
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.naming import by_name
from flexhex.diagnosis.result.verdict import NORMAL, Changed, Named
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.fmus.common.effects import Effect, library

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """An effect that a file states on an axis, from 1; tolerance: one standard deviation of its
    gains, relative."""

    effect: Effect
    axis: int
    shape: Mapping[str, float]
    gains: Array
    tolerance: float

    def parameter(self, gain: str) -> str:
        """As an identification calls it."""
        if self.effect.id in PARAMETER:
            return f"{PARAMETER[self.effect.id]}[{self.axis}]"
        return Extra(self.effect, self.axis - 1, self.shape).parameter(gain)


def stated_of(fit: Joint) -> list[Told]:
    """Those of the base model of a fit."""
    stated = fit.bench.model.base.stated
    return [
        Told(use.effect, axis, use.shape, gains, stated.tolerance)
        for use in stated.uses
        for axis, gains in zip(use.axes, np.transpose(use.gains), strict=True)
    ]


def compared(
    fit: Joint, named: Sequence[Named], open_axes: Container[int], criteria: Criteria
) -> tuple[list[Named], list[Changed], list[str]]:
    """What was named without what the file states; what that has other values of; a sentence on
    what is as it says. open_axes (from 0): those of which a part has no name."""
    rest, changed, as_said = list(named), list[Changed](), dict[str, list[int]]()
    for told in stated_of(fit):
        place = _found(rest, told, criteria)
        if place is not None:
            k, part = place
            found = [part[gain.name] for gain in told.effect.gains if gain.name in part]
            rest[k] = _without(rest[k], told.axis, part)
        elif told.axis - 1 in open_axes or any(_becomes(n, told) for n in rest):
            continue
        else:
            found = _alone(fit, told)
        off = _changes(fit.bench, told, found, criteria)
        changed += off
        if not off and found:
            as_said.setdefault(told.effect.title, []).append(told.axis - 1)
    listed = [f"{title} on {axes_named(axes)}" for title, axes in as_said.items()]
    notes = [f"as the robot's files say: {', '.join(listed)}"] if listed else []
    return [one for one in rest if one.parts], changed, notes


def _found(
    named: Sequence[Named], told: Told, criteria: Criteria
) -> tuple[int, Mapping[str, Estimate]] | None:
    """The part that is such an effect on its axis with its shape: place and estimates. Of several
    the one whose shapes are nearest."""
    near = list[tuple[float, int, Mapping[str, Estimate]]]()
    for k, one in enumerate(named):
        same = one.id == told.effect.id
        if not same and not (told.effect.id in one.rivals and told.axis in one.open):
            continue
        for axis, part in one.parts:
            off = 0.0 if told.effect.varied or not same else _apart(part, told)
            if axis == told.axis and off <= criteria.deviations:
                near.append((off, k, part))
    if not near:
        return None
    _, k, part = min(near, key=lambda one: one[0])
    return k, part


def _apart(part: Mapping[str, Estimate], told: Told) -> float:
    """Largest difference of a shape from the file's, in deviations; one that nothing determines
    has none."""
    return max(
        (_deviations(part[name], value) for name, value in told.shape.items() if name in part),
        default=0.0,
    )


def _deviations(estimate: Estimate, value: float) -> float:
    deviation = _deviation(estimate)
    off = abs(estimate.value - value)
    return off / deviation if deviation > 0 else 0.0 if math.isclose(off, 0.0) else math.inf


def _deviation(estimate: Estimate) -> float:
    return (estimate.ci95[1] - estimate.value) / NORMAL


def _becomes(one: Named, told: Told) -> bool:
    """Whether an effect that was named has the other in its gains."""
    effect = library().get(one.id)
    return effect is not None and effect.extends == told.effect.id and told.axis in one.axes


def _without(named: Named, axis: int, part: Mapping[str, Estimate]) -> Named:
    parts = tuple(own for own in named.parts if own[0] != axis or own[1] is not part)
    axes = tuple(sorted({axis for axis, _ in parts if axis}))
    still = tuple(axis for axis in named.open if axis in axes)
    rivals = named.rivals if still or not named.open else ()
    return replace(
        named, axes=axes, parts=parts, parameters=by_name(parts), open=still, rivals=rivals,
        experiment=named.experiment if rivals else None,
    )  # fmt: skip


def _alone(fit: Joint, told: Told) -> list[Estimate]:
    """Gains of an effect that was not found, fitted beside all that was, in the file's shape; none
    where the runs do not determine them."""
    bench, axis = fit.bench, told.axis - 1
    if told.effect.id not in bench.effects:
        return []
    part = Part.of(bench, told.effect.id, axis, dict(told.shape))
    more = joint(bench, [*fit.effects, SelectedEffect(told.effect.id, (part,))], fit.freed)
    deviation = more.deviation[-1][: len(told.gains)]
    if not (np.isfinite(deviation) & (deviation > 0)).all():
        return []
    kind = bench.scales.kinds[axis]
    listed = zip(told.effect.gains, more.beta[-1].tolist(), deviation.tolist(), strict=False)
    return [
        Estimate(value, (value - NORMAL * wide, value + NORMAL * wide), kind.unit(gain.unit))
        for gain, value, wide in listed
    ]


def _changes(
    bench: Bench, told: Told, found: Sequence[Estimate], criteria: Criteria
) -> list[Changed]:
    """Gains that are surely others than the file's, if their torque is worth a word."""
    size, changes = told.tolerance * float(np.linalg.norm(told.gains)), list[Changed]()
    move = np.array([e.value for e in found]) - told.gains[: len(found)]
    if not len(found) or _share(bench, told, move) < criteria.smallest_effect:
        return []
    for gain, value, estimate, off in zip(
        told.effect.gains, told.gains.tolist(), found, move.tolist(), strict=False
    ):
        if abs(off) > math.hypot(criteria.deviations * _deviation(estimate), NORMAL * size):
            changes.append(Changed(told.parameter(gain.name), value, estimate))
    return changes


def _share(bench: Bench, told: Told, gains: Array) -> float:
    """RMS of the torque of gains, relative to that of the axis."""
    axis = told.axis - 1
    if told.effect.id not in bench.effects:
        return 0.0
    rows = [v[:, : len(gains)] @ gains for v in bench.thin(told.effect.id, axis, told.shape)]
    return float(np.sqrt((np.concatenate(rows) ** 2).mean()) / bench.model.torque_rms[axis])
