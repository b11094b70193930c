"""Whether the runs can be those of the base model's machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, again, torque_of
from flexhex.diagnosis.jointfit.beside import beside
from flexhex.diagnosis.jointfit.fit import EXPLAINED, held
from flexhex.diagnosis.jointfit.leftover import axis_rms, repeat_rms
from flexhex.diagnosis.jointfit.rubbed import friction
from flexhex.diagnosis.kinds import axes_named
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.payloads import GROUP
from flexhex.diagnosis.runs.blocks import torque_rate

Array = NDArray[np.float64]
POOR = 0.5
"""Share of the torque's RMS that a model may leave unexplained."""
TOGETHER = 0.7
"""Least correlation of a torque with the nominal model's. Measured: -0.97 with a turned sign, 0.62
with two axes exchanged; 0.89 and more with another payload, stiffness, damping or offset."""
BENT = 0.05
"""Change of a width or rotor, relative, that bends what is searched beside it."""
FITS = 4
"""Fits until each axis has the variance of what is left there."""
SILENT = 1e6
"""Times its noise with which an axis has no say."""


def poor_axes(model: Calibrated, residual: Sequence[Array]) -> list[int]:
    """Axes (from 0) of which more than `POOR` of the torque is left, both in the rows in which they
    move."""
    left, torque = axis_rms(model.blocks, residual), np.concatenate(model.torque)
    judged = np.concatenate([block.judged for block in model.blocks])
    mean = (torque * judged).sum(axis=0) / np.maximum(judged.sum(axis=0), 1)
    whole = axis_rms(model.blocks, [own - mean for own in model.torque])
    return [int(i) for i in np.flatnonzero(left > POOR * whole)]


def together(model: Calibrated) -> Array:
    """Correlation (n,) of each axis' torque with that of the machine file's own parameters and the
    payloads of the fit: of all of it or beside friction, which may be most of it, the larger one.

    A fit may turn the sign of all inertias to please a log whose sign is turned; what it leaves
    then looks like effects.
    """
    carried = np.array([known.group == GROUP for known in model.known])
    nominal = np.where(carried, model.regression.q, model.nominal)
    left = model.residual(nominal)
    usable = [b.usable for b in model.blocks]
    whole, rest, rubbed = (
        np.concatenate([part[good] for part, good in zip(parts, usable, strict=True)])
        for parts in (model.torque, left, friction(model.blocks))
    )
    axes = range(model.base.n)
    pairs = [_correlations(whole[:, i], whole[:, i] - rest[:, i], rubbed[:, i]) for i in axes]
    return np.asarray(np.max(pairs, axis=1))


def _correlations(one: Array, other: Array, beside: Array) -> tuple[float, float]:
    """Correlation of two signals (rows,), and the same beside columns (rows, k)."""
    pairs = []
    for columns in (np.ones((len(one), 1)), beside):
        both = np.column_stack([one, other])
        both = both - columns @ np.linalg.lstsq(columns, both)[0]
        squares = both.T @ both
        pairs.append(float(squares[0, 1] / max(np.sqrt(squares[0, 0] * squares[1, 1]), 1e-300)))
    return pairs[0], pairs[1]


def moved(before: Calibrated, after: Calibrated, fit: Joint, least: float) -> bool:
    """Whether widths or the rotors of geared axes are others after a fit to what was found, or the
    delay is by what makes more torque on an axis than `least`, relative, and than the fit leaves
    there, or what drives lose, by as much in the second order, or the torque of effects that go
    with torques."""
    widths = np.abs(np.log(after.fitted.widths / before.fitted.widths)).max(initial=0.0)
    places = [before.base.rotors[axis] for axis in fit.geared]
    rotors = np.abs(after.fitted.p[places] - before.fitted.p[places])
    turned = (rotors > BENT * np.abs(before.fitted.p[places])).any()
    lost = np.abs((after.fitted.losses - before.fitted.losses) * after.fitted.losses)
    bent = widths > BENT or turned or np.any(lost > least)
    return bool(bent or _with_torque(after, fit, least) or _later(before, after, fit, least))


def _with_torque(after: Calibrated, fit: Joint, least: float) -> bool:
    """Whether the torque of effects that go with torques is another one with the same gains."""
    known, listed = fit.bench.effects, zip(fit.parts, fit.beta, strict=True)
    own = [(p, gains) for p, gains in listed if p.id in known and not known[p.id].moved]
    parts, beta = [part for part, _ in own], [gains for _, gains in own]
    if not parts:
        return False
    then, now = (torque_of(b, parts, beta) for b in (fit.bench, fit.bench.beside(after)))
    change = axis_rms(after.blocks, [b - a for a, b in zip(then, now, strict=True)])
    return bool((change > least * after.torque_rms).any())


def _later(before: Calibrated, after: Calibrated, fit: Joint, least: float) -> bool:
    """Whether the delay moved by so much."""
    delay = after.fitted.delay
    if delay == before.fitted.delay:
        return False
    rates = [torque_rate(block, after.base.window, delay) for block in after.blocks]
    torque = abs(delay - before.fitted.delay) * axis_rms(after.blocks, rates)
    return bool((torque > np.maximum(least * after.torque_rms, left_rms(fit))).any())


def without_bent_delay(fit: Joint, deviations: float, least: float) -> Calibrated | None:
    """The base model with the delay of the torques that those axes ask for on which nothing is left
    then, none if there are none, and no freedom for another one, if the fit has a clear one that
    does not explain what is left: another cause bends it then. None else.

    A delay is common to all axes. So it takes from the repeatable residual of each, and what it
    leaves is compared as the likelihood of all axes is, each with a variance of its own: one axis
    on which something else is missing has no say over those that fit. deviations: standard errors
    that a clear one stands above zero; least: relative RMS below which nothing is left.
    """
    late, deviation = delay_of(fit)
    if abs(late) < deviations * deviation:
        return None
    delay = _asked_by_axes_that_fit(fit, least)
    if abs(delay - late) < deviation:
        return None
    model = held(fit.bench.model, delay)
    alone = again(fit, Bench(model, list(fit.bench.effects.values())))
    after, before = (
        np.maximum(left_rms(f), least * f.bench.model.torque_rms) for f in (fit, alone)
    )
    return None if np.prod((after / before) ** 2) < EXPLAINED else model


def without_lags(fit: Joint, deviations: float) -> Calibrated | None:
    """The base model with the delay of the torques of the axis that asks for the least lag, and no
    freedom for another one, if the fit has a clear one with more. None else.

    A delay is common to all axes, a lag of a drive adds to it on its own. deviations: standard
    errors that differences count from.
    """
    late, deviation = delay_of(fit)
    if abs(late) < deviations * deviation:
        return None
    asked = [delay_of(_weighed(fit, own)) for own in np.where(np.eye(fit.bench.n), 1.0, SILENT)]
    ahead = [one for one, own in asked if one - late > deviations * np.hypot(own, deviation)]
    return held(fit.bench.model, max(ahead)) if ahead else None


def _asked_by_axes_that_fit(fit: Joint, least: float) -> float:
    """The delay of the torques [s] in a fit in which each axis has the variance of what is left
    there, the largest likelihood of all; zero if something is left on all of them."""
    for _ in range(FITS):
        model = fit.bench.model
        left = [model.white(i, [own[:, i] for own in fit.residual]) for i in range(model.base.n)]
        fit = _weighed(fit, np.array([float(np.sqrt((own**2).mean())) for own in left]))
    fits = left_rms(fit) < least * fit.bench.model.torque_rms
    return delay_of(fit)[0] if fits.any() else 0.0


def _weighed(fit: Joint, times: Array) -> Joint:
    """The same with so many times (n,) the noise on each axis."""
    model = fit.bench.model
    even = replace(model, noise=replace(model.noise, scale=model.noise.scale * times))
    return again(fit, Bench(even, list(fit.bench.effects.values())))


def left_rms(fit: Joint) -> Array:
    """RMS (n,) of what a fit leaves [N m]: of what repeats, where runs do."""
    model = fit.bench.model
    if not model.noise.repeats:
        return axis_rms(model.blocks, fit.residual)
    return repeat_rms(model, fit.residual)[0]


def delay_of(fit: Joint) -> tuple[float, float]:
    """The torques' common delay and its standard deviation [s]."""
    model = fit.bench.model
    place = next(i for i, known in enumerate(model.known) if known.group == "delay")
    scale, deviation = model.scale[place], fit.covariance[place, place] ** 0.5
    return float(model.fitted.expected + fit.q[place] * scale), float(deviation * scale)


def clear(fit: Joint, deviations: float) -> bool:
    """Whether the torques' common delay is worth a word and stands above zero."""
    late, deviation = delay_of(fit)
    # a motion turns somewhere within a sample, and friction with it: less is no delay
    sample = max(block.run.tau.ts for block in fit.bench.model.blocks)
    return abs(late) >= max(sample, deviations * deviation)


def delayed(fit: Joint, deviations: float, whole: bool) -> str:
    """What is said of the torques' common delay beside all that was found, or nothing: alone, the
    base model takes friction and cogging for a part of one. deviations: standard errors that it
    must stand above zero; whole: nothing is left that may look like one."""
    model = fit.bench.model
    if clear(fit, deviations):
        # its tangent stood at the delay of the first fit
        fit = again(fit, Bench(beside(fit), list(fit.bench.effects.values())))
    if not clear(fit, deviations):
        return ""
    late, _ = delay_of(fit)
    where = " on all axes" if model.base.n > 1 else ""
    alone = "" if model.base.n > 1 else "; a single axis does not show whether its drive is late"
    verb = "lags" if late > 0 else "leads"
    or_else = "" if whole else ", or what is left without a name looks like that"
    return (
        f"the torque channel {verb} the angles by {1e3 * abs(late):.2g} ms{where}{or_else}; treated"
        f" as logger delay and compensated{alone}"
    )


def sentence(axes: Sequence[int]) -> str:
    """What is said of such axes."""
    return (
        f"more than {POOR:.0%} of the torque of {axes_named(axes)} stays unexplained by all that"
        " was found: nothing is named there"
    )
