"""Base parameters that left their tolerances, and payloads that no log announces: their values with
intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, erfc

from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.regression.payloads import Load
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import NORMAL, Changed, Tolerated

Array = NDArray[np.float64]
LENGTHS = 0.003
"""Relative error of a machine's lengths, and so of a mass that its torques tell: one standard
deviation."""


def changed_of(fit: Joint, bodies: Sequence[Sequence[int]]) -> list[Changed]:
    """Parameters (places in `known`) that changed, of each body or alone.

    Of a body those are given whose interval does not hold the value of the machine file; one at
    least, unless the region of all of them together holds theirs: beside what else was found they
    are what the file says. What no machine has at or below zero is not given there.
    """
    model, changed = fit.bench.model, dict[int, Changed]()
    bodies = _with_heavier(fit, bodies)
    if not bodies:
        return []
    spread = fit.covariance * np.outer(model.scale, model.scale)
    deviation = np.sqrt(np.maximum(np.diag(spread), 0.0))
    moved = np.array([known.nominal - known.written for known in model.known])
    move = model.scale * fit.q + moved
    off = np.abs(move) / np.maximum(NORMAL * deviation, np.finfo(float).tiny)
    for place, known in enumerate(model.known):
        if known.positive and known.written + move[place] <= 0:
            off[place] = 0.0
    for places in bodies:
        if _as_written(move[list(places)], spread[np.ix_(places, places)]):
            continue
        clear = {place for place in places if off[place] > 1.0}
        most = max(places, key=lambda place: float(off[place]))
        for place in sorted(clear | {most}):
            known = model.known[place]
            changed[place] = _change(
                known.name, known.written, move[place], deviation[place], known.printed
            )
    return list(changed.values())


def _as_written(move: Array, covariance: Array) -> bool:
    """Whether the 95 % region of parameters together holds those of the machine file."""
    size = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    inverse = np.linalg.pinv(covariance / np.outer(size, size), hermitian=True)
    square = float((move / size) @ inverse @ (move / size))
    return bool(chdtrc(len(move), square) > erfc(NORMAL / np.sqrt(2)))


def tolerated_of(fit: Joint, sure: float, least: float) -> tuple[Tolerated, ...]:
    """Errors of the geometry that have not left their tolerances, stand `sure` deviations above
    zero, and make more than a share `least` of an axis' torque: the largest share first."""
    model = fit.bench.model
    errors = model.base.geometry.known if model.base.geometry else ()
    first = model.known.index(errors[0]) if errors else 0
    deviation = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    places = np.arange(first, first + len(errors))
    places = places[np.abs(fit.q[places]) > sure * deviation[places]]
    places = places[[place not in fit.freed for place in places]]
    axes = range(model.base.n)
    squares = np.array([(model.kept_B.at(i, places) ** 2).mean(axis=0) for i in axes])
    share = np.abs(fit.q[places]) * np.sqrt(squares) / model.torque_rms[:, None]
    listed = []
    for place, own in zip(places, share.T, strict=True):
        known, wide = model.known[place], deviation[place] * model.scale[place]
        one = _change(
            known.name, known.written, model.scale[place] * fit.q[place], wide, known.printed
        )
        axis = int(np.argmax(own))
        more = known.tolerance, axis + 1, float(own[axis])
        listed.append(Tolerated(one.parameter, one.nominal, one.estimate, (), *more))
    above = [one for one in listed if one.share > least]
    return tuple(sorted(above, key=lambda one: -one.share))


def impossible(fit: Joint, bodies: Sequence[Sequence[int]]) -> list[str]:
    """Parameters (places in `known`) that left their tolerances for values that no machine has:
    masses, and all else of which the whole interval is such."""
    model, names = fit.bench.model, list[str]()
    deviation = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    for place in sorted({place for body in _with_heavier(fit, bodies) for place in body}):
        known, spread = model.known[place], NORMAL * deviation[place]
        most = fit.q[place] + (0.0 if known.unit == "kg" else spread)
        if known.positive and known.nominal + model.scale[place] * most <= 0:
            names.append(known.name)
    return names


def _with_heavier(fit: Joint, bodies: Sequence[Sequence[int]]) -> list[Sequence[int]]:
    """Places of parameters that left their tolerances, and those of bodies that have another mass
    in the base model already."""
    owners = dict[str, list[int]]()
    for place, known in enumerate(fit.bench.model.known):
        if known.file is not None:
            owners.setdefault(known.name.rpartition(".")[0] or known.name, []).append(place)
    return [*bodies, *owners.values()]


def payload_changes(fit: Joint) -> list[Changed]:
    """Every payload that only the runs show: mass and centre where the runs determine them; of
    axes without a known mechanism the parameters that it surely adds to."""
    model, changes = fit.bench.model, list[Changed]()
    for load in model.loads:
        if load.bit is None:
            continue
        part, runs = model.places(load), [b.run.name for b in model.blocks if load.on(b.run)]
        scale = model.scale[part]
        spread = fit.covariance[part, part] * np.outer(scale, scale)
        listed = _payload(load, scale * fit.q[part], spread, model.base.reach)
        changes += [replace(change, runs=tuple(runs)) for change in listed]
    return changes


def _payload(load: Load, value: Array, covariance: Array, reach: float) -> list[Changed]:
    """What is said of a payload with these parameters."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    sure = np.abs(value) > NORMAL * deviation
    units = [known.unit for known in load.known]
    if not np.isfinite(reach) or not sure[units.index("kg")]:
        shown = np.flatnonzero(sure)
        return [
            _change(load.known[k].name, 0.0, value[k], deviation[k], load.known[k].printed)
            for k in shown
        ]
    m = units.index("kg")
    mass = float(value[m])
    changes = [_change(load.name, 0.0, mass, float(np.hypot(deviation[m], LENGTHS * mass)), "kg")]
    for k in (k for k, unit in enumerate(units) if unit == "kg m"):
        centre = float(value[k]) / mass
        slope = np.array([1.0, -centre]) / mass
        spread = float(np.sqrt(slope @ covariance[np.ix_([k, m], [k, m])] @ slope))
        if NORMAL * spread < reach:
            name = load.known[k].name.replace(".mc_", ".c_")
            changes.append(_change(name, 0.0, centre, spread, "m"))
    return changes


def _change(name: str, nominal: float, move: float, deviation: float, unit: str) -> Changed:
    value, wide = nominal + float(move), NORMAL * float(deviation)
    return Changed(name, nominal, Estimate(value, (value - wide, value + wide), unit))
