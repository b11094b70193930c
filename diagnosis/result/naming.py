"""What was found in words of the library: effects with estimates and rivals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from flexhex.diagnosis.jointfit.answer import Joint, shares
from flexhex.diagnosis.jointfit.found import Part
from flexhex.diagnosis.result.verdict import Estimate, Named
from flexhex.fmus.common.effects import library


def named_of(held: Joint, errors: Mapping[bool, float]) -> list[Named]:
    """Effects of a fit, each with all its axes. errors: of a form, one standard
    deviation of its mean, relative, by whether the form is exact: it moves gains and shapes."""
    rivals = {effect.id: effect.rivals for effect in held.effects}
    # of what changes from run to run nobody knows how much is noise
    known_share = shares(held) if held.bench.made.between else [math.nan] * len(held.effects)
    share = dict(zip([e.id for e in held.effects], known_share, strict=True))
    grouped: dict[str, list[int]] = {}
    for k, part in enumerate(held.parts):
        grouped.setdefault(part.id, []).append(k)
    known = {id: item.effect for id, item in held.bench.effects.items()} | dict(library())
    made = []
    for name, places in grouped.items():
        parts = [(_axis(held.parts[k]), _estimates(held, k, errors)) for k in places]
        axes = tuple(sorted({axis for axis, _ in parts if axis}))
        others = tuple(r for r in rivals.get(name, ()) if r not in grouped)
        made.append(
            Named(
                name,
                known[name].title,
                axes,
                _flat(parts),
                tuple(parts),
                others,
                known[name].experiment if others else None,
                share[name],
            )
        )
    return made


def _axis(part: Part) -> int:
    return 0 if part.axis is None else part.axis + 1


def _estimates(held: Joint, k: int, errors: Mapping[bool, float]) -> dict[str, Estimate]:
    """Gains, then shapes, of one part."""
    part = held.parts[k]
    item = held.bench.effects.get(part.id)
    effect = library()[part.id] if item is None or part.id in library() else item.effect
    found = {}
    kind = held.bench.scales.kinds[part.axis or 0]
    for gain, value, std in zip(effect.gains, held.beta[k], held.deviation[k], strict=True):
        alike = [v for g, v in zip(effect.gains, held.beta[k], strict=True) if g.unit == gain.unit]
        wide = float(np.hypot(std, errors[effect.exact] * np.linalg.norm(alike)))
        found[gain.name] = _estimate(float(value), wide, kind.unit(gain.unit))
    for shape in effect.shapes:
        std = held.shape_deviation[k].get(shape.name, 0.0)
        bent = errors[effect.exact] * held.bent[k].get(shape.name, 0.0)
        wide = float(np.hypot(std, bent))
        found[shape.name] = _estimate(part.shape[shape.name], wide, kind.unit(shape.unit))
    return found


def _estimate(value: float, std: float, unit: str) -> Estimate:
    return Estimate(value, (value - 1.96 * std, value + 1.96 * std), unit)


def _flat(parts: Sequence[tuple[int, Mapping[str, Estimate]]]) -> dict[str, Estimate]:
    several = len({axis for axis, _ in parts}) > 1
    flat: dict[str, Estimate] = {}
    for axis, estimates in parts:
        for name, estimate in estimates.items():
            key = f"{name}[{axis}]" if several else name
            count, unique = 2, key
            while unique in flat:
                unique, count = f"{key}#{count}", count + 1
            flat[unique] = estimate
    return flat
