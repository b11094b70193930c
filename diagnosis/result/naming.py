"""What was found in words of the library: effects with estimates and rivals."""

from __future__ import annotations

import math
from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.jointfit.answer import Joint, shares, torque_of
from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.kinds import with_unit
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import NORMAL, Named
from flexhex.fmus.common.effects import Effect, library


def named_of(fit: Joint, errors: Sequence[float], but: Container[int] = ()) -> list[Named]:
    """Effects of a fit, each with all its axes, the largest share of its axes' torque first; of
    several on one axis the lowest harmonic first.

    Not those that are as small as every machine may have them, nor those `but` at some places of
    the parts. errors: of the form of each part, one standard deviation of its mean, relative: it
    moves gains and shapes.
    """
    # of what changes from run to run nobody knows how much is noise
    known_share = shares(fit) if fit.bench.model.between else [math.nan] * len(fit.effects)
    share = dict(zip([e.id for e in fit.effects], known_share, strict=True))
    known, usual = _known(fit), _usual(fit)
    grouped: dict[str, list[int]] = {}
    for k, part in enumerate(fit.parts):
        if k not in usual and k not in but:
            grouped.setdefault(part.id, []).append(k)
    named = []
    for name, own in sorted(grouped.items(), key=lambda item: -_share_of_torque(fit, item[1])):
        places = sorted(own, key=lambda k: (_axis(fit.parts[k]), *fit.parts[k].shape.values()))
        parts = [(_axis(fit.parts[k]), _estimates(fit, k, errors[k])) for k in places]
        axes = tuple(sorted({axis for axis, _ in parts if axis}))
        rivals = [(_axis(fit.parts[k]), _rivals(fit, k, grouped)) for k in places]
        others = tuple(dict.fromkeys(rival for _, own in rivals for rival in own))
        named.append(
            Named(
                name,
                known[name].title,
                axes,
                by_name(parts),
                tuple(parts),
                others,
                known[name].experiment if others else None,
                share[name],
                tuple(sorted({axis for axis, own in rivals if axis and own})),
                known[name].origin,
            )
        )
    return named


def _rivals(fit: Joint, k: int, named: Mapping[str, Sequence[int]]) -> list[str]:
    """Other names of a part: what is named on this very axis is none, what is on others may be."""
    part = fit.parts[k]
    there = {
        name for name, places in named.items() if part.axis in (fit.parts[j].axis for j in places)
    }
    return [rival for rival in part.rivals if rival not in there]


def usual_parts(fit: Joint) -> list[str]:
    """A sentence on each part of a fit that is as small as every machine may have it."""
    known, torque = _known(fit), fit.bench.model.torque_rms
    sentences = []
    for k, size in _usual(fit).items():
        part, axis = fit.parts[k], fit.parts[k].axis or 0
        rms = f"{size * torque[axis]:.2g} {fit.bench.scales.kinds[axis].unit('N m')}"
        title = known[part.id].title
        sentences.append(f"{title} on axis {axis + 1}, {rms}: in the fit, but no more than usual")
    return sentences


def unnamed_parts(fit: Joint, places: Collection[int]) -> list[str]:
    """A sentence on each part of a fit, at these places, that is not named, as much is left beside
    it or something that the library lacks would explain as much, with its values: who expects it
    may want them."""
    why = "in the fit, but not named: it may stand for something that the library lacks"
    return [f"{_in_words(fit, k)}: {why}" for k in sorted(places)]


def faint_parts(fit: Joint, places: Collection[int]) -> list[str]:
    """A sentence on each part of a fit, at these places, that is too faint for a name."""
    why = "too faint for a name, as it may be an error in the form of what is named there: values"
    ends = "and residuals above are without it, intervals hold with it and without it"
    return [f"{_in_words(fit, k)}: {why} {ends}" for k in sorted(places)]


def _in_words(fit: Joint, k: int) -> str:
    """A part of a fit with its axis and values."""
    part, listed = fit.parts[k], _estimates(fit, k, 0.0).items()
    told = [with_unit(f"{name} {own.value:.3g}", own.unit) for name, own in listed if own.told]
    values = ", ".join(told)
    return f"{_known(fit)[part.id].title} on axis {(part.axis or 0) + 1} ({values})"


def widened(named: Sequence[Named], others: Sequence[Named]) -> list[Named]:
    """Effects whose intervals also hold where the same ones have other values."""
    known = dict[tuple[str, int], list[Mapping[str, Estimate]]]()
    for other in others:
        for axis, own in other.parts:
            known.setdefault((other.id, axis), []).append(own)
    wider = list[Named]()
    for each in named:
        parts = list[tuple[int, Mapping[str, Estimate]]]()
        for axis, own in each.parts:
            # what would be no finding beside the others has no other values
            there = known[each.id, axis].pop(0) if known.get((each.id, axis)) else own
            parts.append((axis, {name: _wider(own[name], there[name]) for name in own}))
        wider.append(replace(each, parts=tuple(parts), parameters=by_name(parts)))
    return wider


def _wider(one: Estimate, other: Estimate) -> Estimate:
    """The same value with an interval that holds that of another estimate, too."""
    (low, high), (less, more) = one.ci95, other.ci95
    return replace(one, ci95=(min(low, less), max(high, more)))


def _usual(fit: Joint) -> dict[int, float]:
    """Places of the parts that are no finding, and their size relative to the torque."""
    known, places = _known(fit), range(len(fit.parts))
    sizes = {k: _share_of_torque(fit, [k]) for k in places if known[fit.parts[k].id].usual}
    return {k: size for k, size in sizes.items() if size <= known[fit.parts[k].id].usual}


def _known(fit: Joint) -> Mapping[str, Effect]:
    """Effects by their ids."""
    return {id: item.effect for id, item in fit.bench.effects.items()} | dict(library())


def _share_of_torque(fit: Joint, places: Sequence[int]) -> float:
    """RMS of the torque of these parts on all axes, each relative to that of the axis."""
    gains = [fit.beta[k] for k in places]
    torque = np.concatenate(torque_of(fit.bench, [fit.parts[k] for k in places], gains))
    return float(np.sqrt(((torque / fit.bench.model.torque_rms) ** 2).mean(axis=0).sum()))


def _axis(part: Part) -> int:
    return 0 if part.axis is None else part.axis + 1


def _estimates(fit: Joint, k: int, error: float) -> dict[str, Estimate]:
    """Gains, then shapes, of one part; error: of its form. A shape with no other value to try and
    an effect that is there in full say nothing to a reader."""
    part = fit.parts[k]
    item = fit.bench.effects.get(part.id)
    effect = library()[part.id] if item is None or part.id in library() else item.effect
    estimates = {}
    kind = fit.bench.scales.kinds[part.axis or 0]
    count = len(effect.gains)  # the others are the diagnosis' own
    beta, deviation, turns = (own[k][:count] for own in (fit.beta, fit.deviation, fit.turned))
    for gain, value, std, turned in zip(effect.gains, beta, deviation, turns, strict=True):
        alike = [v for g, v in zip(effect.gains, beta, strict=True) if g.unit == gain.unit]
        wide = float(np.linalg.norm([std, error * np.linalg.norm(alike), error * turned]))
        unit, positive = kind.unit(gain.unit), gain.low == 0
        one = _estimate(float(value), wide, unit, positive)
        estimates[gain.name] = replace(one, told=not gain.full or one.ci95[1] < gain.high)
    tried = effect.shapes if item is None else item.effect.shapes
    searched = {shape.name for shape in tried if len(shape.grid) > 1}
    for shape in (own for own in effect.shapes if not own.aside):
        std = fit.deviations.shapes[k].get(shape.name, 0.0)
        bent = error * fit.deviations.bent[k].get(shape.name, 0.0)
        wide = float(np.hypot(std, bent))
        unit, positive = kind.unit(shape.unit), shape.low >= 0
        one = _estimate(part.shape[shape.name], wide, unit, positive)
        estimates[shape.name] = replace(one, told=shape.name in searched)
    return estimates


def _estimate(value: float, std: float, unit: str, positive: bool) -> Estimate:
    """positive: it cannot lie below zero; where nothing is known of it the interval has no ends."""
    low, high = value - NORMAL * std, value + NORMAL * std
    return Estimate(value, (max(low, 0.0) if positive and np.isfinite(std) else low, high), unit)


def by_name(parts: Sequence[tuple[int, Mapping[str, Estimate]]]) -> dict[str, Estimate]:
    """Estimates of an effect's parts in one: `Named.parameters`."""
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
