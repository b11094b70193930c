"""Effects that the model's file states, beside what the runs show: the search finds them as it
finds all others. One that comes out as the file has it is no finding; another value is a change."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.stated import Told, stated_of
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.kinds import axes_named
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.naming import by_name
from flexhex.diagnosis.result.verdict import NORMAL, Changed, Named
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.side import Side
from flexhex.fmus.common.effects import library

Array = NDArray[np.float64]
Estimates = Mapping[str, Estimate]


@dataclass
class Compared:
    """What was named without what the file states; what that has other values of; what is as it
    says, and what the runs do not tell of it: axes (from 0) by titles."""

    named: list[Named]
    changed: list[Changed] = field(default_factory=list)
    as_said: dict[str, list[int]] = field(default_factory=dict)
    untold: dict[str, list[int]] = field(default_factory=dict)

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader."""
        listed = [
            ", ".join(f"{title} on {axes_named(axes)}" for title, axes in of.items())
            for of in (self.as_said, self.untold)
        ]
        said, untold = listed
        texts = [f"as the robot's files say: {said}"] if said else []
        if untold:
            texts.append(f"in the robot's files, but not determined by these runs: {untold}")
        return texts


def beside_the_file(side: Side, criteria: Criteria) -> Side:
    """A side of the answer without what the file states."""
    done = compared(side.fit, side.named, side.remains, criteria)
    return replace(
        side,
        named=tuple(done.named),
        changed=(*side.changed, *done.changed),
        notes=(*done.notes, *side.notes),
    )


def compared(
    fit: Joint, named: Sequence[Named], remains: Container[int], criteria: Criteria
) -> Compared:
    """What was named beside what the file states. remains: axes (from 0) with more than was
    explained, of which nothing else is said."""
    done = Compared(list(named))
    for told in stated_of(fit.bench.model.base):
        place, sure = _found(done.named, told, criteria), True
        if place is not None:
            k, part = place
            other = done.named[k].id
            done.named[k] = _without(done.named[k], told.axis, part)
            found = dict(part) if other == told.effect.id else _beside(fit, told, other)
        elif told.axis - 1 in remains or any(_becomes(one, told) for one in done.named):
            continue
        elif own := _in_fit(fit, told, named, criteria):
            # in the fit, but as small as every machine may have it, or of a doubtful form
            found, sure = own, False
        else:
            found = _beside(fit, told)
        if not found:
            done.untold.setdefault(told.effect.title, []).append(told.axis - 1)
            continue
        off = _changes(fit.bench, told, found, criteria)
        if off:
            done.changed += off if sure else []
            continue
        of = done.as_said if _shown(told, found) else done.untold
        of.setdefault(told.effect.title, []).append(told.axis - 1)
    done.named = [one for one in done.named if one.parts]
    return done


def _found(named: Sequence[Named], told: Told, criteria: Criteria) -> tuple[int, Estimates] | None:
    """The part on its axis that is such an effect with its shape, or that these runs cannot tell
    from it, or what the effect is without its further gains: place and estimates. Of several the
    one whose shapes are nearest."""
    near = list[tuple[bool, float, int, Estimates]]()
    for k, one in enumerate(named):
        same = one.id == told.effect.id
        rival = told.effect.id in one.rivals and told.axis in one.open
        if not (same or rival or one.id == told.effect.extends):
            continue
        for axis, part in one.parts:
            off = 0.0 if told.effect.varied or not same else _apart(part, told)
            if axis == told.axis and off <= criteria.deviations:
                near.append((not same, off, k, part))
    if not near:
        return None
    *_, k, part = min(near, key=lambda one: one[:3])
    return k, part


def _apart(part: Estimates, told: Told) -> float:
    """Largest difference of a shape from the file's, in deviations; one that nothing determines
    has none."""
    return max(
        (_deviations(part[name], value) for name, value in told.shape.items() if name in part),
        default=0.0,
    )


def _deviations(estimate: Estimate, value: float) -> float:
    deviation, off = _deviation(estimate), abs(estimate.value - value)
    return off / deviation if deviation > 0 else 0.0 if math.isclose(off, 0.0) else math.inf


def _deviation(estimate: Estimate) -> float:
    return (estimate.ci95[1] - estimate.value) / NORMAL


def _becomes(one: Named, told: Told) -> bool:
    """Whether an effect that was named has the other in its gains."""
    effect = library().get(one.id)
    return effect is not None and effect.extends == told.effect.id and told.axis in one.axes


def _without(named: Named, axis: int, part: Estimates) -> Named:
    parts = tuple(own for own in named.parts if own[0] != axis or own[1] is not part)
    axes = tuple(sorted({axis for axis, _ in parts if axis}))
    still = tuple(axis for axis in named.open if axis in axes)
    rivals = named.rivals if still else ()
    return replace(
        named, axes=axes, parts=parts, parameters=by_name(parts), open=still, rivals=rivals,
        experiment=named.experiment if rivals else None,
    )  # fmt: skip


def _in_fit(
    fit: Joint, told: Told, named: Sequence[Named], criteria: Criteria
) -> dict[str, Estimate]:
    """Gains of an effect that is in the fit without a name; of several the first."""
    if any(one.id == told.effect.id and told.axis in one.axes for one in named):
        return {}
    for part, beta, deviation in zip(fit.parts, fit.beta, fit.deviation, strict=True):
        if (part.id, part.axis) != (told.effect.id, told.axis - 1):
            continue
        if told.effect.varied or all(
            math.isclose(part.shape[name], value, rel_tol=criteria.exact_form_error)
            for name, value in told.shape.items()
        ):
            return _estimates(fit.bench, told, beta, deviation)
    return {}


def _beside(fit: Joint, told: Told, instead_of: str = "") -> dict[str, Estimate]:
    """Gains of an effect that was not found, fitted beside all that was, or in the place of one, in
    the file's shape; none where the runs do not determine them."""
    bench, axis = fit.bench, told.axis - 1
    if told.effect.id not in bench.effects:
        return {}
    effects = [
        replace(e, parts=tuple(p for p in e.parts if (p.id, p.axis) != (instead_of, axis)))
        for e in fit.effects
    ]
    part = Part.of(bench, told.effect.id, axis, dict(told.shape))
    more = joint(bench, [*effects, SelectedEffect(told.effect.id, (part,))], fit.freed)
    return _estimates(bench, told, more.beta[-1], more.deviation[-1])


def _estimates(bench: Bench, told: Told, beta: Array, deviation: Array) -> dict[str, Estimate]:
    """By the names of the gains; none where one is not determined."""
    gains, kind = told.effect.gains, bench.scales.kinds[told.axis - 1]
    wide = NORMAL * deviation[: len(gains)]
    if not (np.isfinite(wide) & (wide > 0)).all():
        return {}
    return {
        gain.name: Estimate(value, (value - most, value + most), kind.unit(gain.unit))
        for gain, value, most in zip(gains, beta.tolist(), wide.tolist(), strict=False)
    }


def _shown(told: Told, found: Estimates) -> bool:
    """Whether the runs tell the effect from none."""
    pairs = zip(told.effect.gains, told.gains, strict=True)
    return any(abs(v) > NORMAL * _deviation(found[g.name]) for g, v in pairs if g.name in found)


def _changes(bench: Bench, told: Told, found: Estimates, criteria: Criteria) -> list[Changed]:
    """Gains that are surely others than the file's, if their torque is worth a word."""
    gains, values, changes = told.effect.gains, np.array(told.gains), list[Changed]()
    move = np.array([found[g.name].value if g.name in found else 0.0 for g in gains]) - values
    if _share(bench, told, move) < criteria.smallest_effect:
        return []
    tolerance = bench.model.base.stated.tolerance
    names = list(told.named)
    for k, gain in enumerate(gains):
        alike = [j for j, other in enumerate(gains) if other.unit == gain.unit]
        size = tolerance * float(np.linalg.norm(values[alike]))
        estimate = found.get(gain.name)
        if estimate is None:
            continue
        if abs(move[k]) > math.hypot(criteria.deviations * _deviation(estimate), NORMAL * size):
            changes.append(Changed(names[k], told.gains[k], estimate))
    return changes


def _share(bench: Bench, told: Told, gains: Array) -> float:
    """RMS of the torque of gains, relative to that of the axis."""
    axis = told.axis - 1
    if told.effect.id not in bench.effects:
        return 0.0
    rows = [v[:, : len(gains)] @ gains for v in bench.thin(told.effect.id, axis, told.shape)]
    return float(np.sqrt((np.concatenate(rows) ** 2).mean()) / bench.model.torque_rms[axis])
