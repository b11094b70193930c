"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.answer import Joint, again
from flexhex.diagnosis.jointfit.guess import first_guess
from flexhex.diagnosis.jointfit.known import about_known, known_torque
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted, FixedEffect
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.linearize import about
from flexhex.diagnosis.runs.blocks import LATEST, Block
from flexhex.diagnosis.runs.noise import Noise, measured, unweighted

Array = NDArray[np.float64]
STEPS = 2
"""Gauss-Newton steps."""
EXPLAINED = 0.5
"""Part of the product of the squares that all axes leave without a delay, below which it is one."""
HELD = 1e-5
"""Tolerance of a delay that is held, of the usual one."""
MISLED = 1.25
"""Ratio of what is left of an axis' torque, weighted by its noise against not weighted, beyond
which the weights do harm; and of a fit beside friction against one without it, which is wrong then.
"""
FITS = 6
"""Fits until each axis has the weight of what is left there."""
STEPS_BESIDE, STRIDE, SETTLED = 6, 0.4, 0.02
"""Beside effects: most steps, and the longest of a width, relative; change of widths and weights,
relative, and of the delay, in tolerances, below which a fit has settled."""


def calibrate(base: Base, blocks: Sequence[Block]) -> Calibrated:
    """Fit the base model: the linear part, then widths and delay by Gauss-Newton.

    What the effects that the model has already explain is taken off first. Friction that it does
    not have looks like a delay: so delay and noise are those beside one. A delay beyond its
    tolerance that does not explain much of what is left is none, until something else does.
    """
    model, left = _calibrated(base, blocks, 1.0)
    if abs(model.fitted.delay) <= model.fitted.late:
        return model
    held, most = _calibrated(base, blocks, HELD)
    return model if np.prod((left / most) ** 2) < EXPLAINED else held


def _calibrated(base: Base, blocks: Sequence[Block], share: float) -> tuple[Calibrated, Array]:
    """The same with so much of a delay's tolerance, and the RMS (n,) [N m] that is left of each
    axis beside friction."""
    late = share * _tolerance(base, blocks)
    p, delay = first_guess(base, blocks, late)
    fitted = Fitted(
        p,
        np.array([k.nominal for k in base.curved]),
        np.array([k.nominal for k in base.widths]),
        delay,
        late,
    )
    flat = Noise.even(base.n, 1.0)
    first = with_friction(about(base, blocks, fitted, flat))
    given = known_torque(first)
    plain = first.residual(first.regression.q)
    noise = measured(blocks, plain)
    first.forget()
    misled, most = np.zeros(base.n, dtype=bool), MISLED * axis_rms(blocks, plain)
    while True:
        rubbed = _weighted(first, unweighted(noise, misled), given)
        left = rubbed.residual(rubbed.regression.q)
        # axes are coupled: another weight of one may mislead the next
        more = ~misled & (axis_rms(blocks, left) > most)
        if not more.any():
            break
        misled |= more
    rubbed = _weighted(first, unweighted(noise, misled), given, rubbed.doubted(left))
    rubbed, q, off = _evenly(rubbed, given)
    left = rubbed.residual(q)
    noise = unweighted(measured(blocks, left), misled)
    model = about(base, blocks, rubbed.fitted, noise, (), given, rubbed.errors)
    model = replace(model, noise=_even(model, left))
    return replace(model, off=off).doubted(left), axis_rms(blocks, left)


def _tolerance(base: Base, blocks: Sequence[Block]) -> float:
    """Standard deviation of the torques' common delay, before any fit [s]."""
    return base.late * max(block.run.tau.ts for block in blocks)


def held(model: Calibrated, delay: float, lag: float = 0.0) -> Calibrated:
    """The base model with a delay of the torques [s] and no freedom for another one; lag: about
    which one of the drive is taken [s]."""
    late = HELD * _tolerance(model.base, model.blocks)
    fitted = replace(model.fitted, delay=delay, expected=delay, late=late, lag=lag)
    now = about_known(model.base, model.blocks, fitted, model.noise, (), model.errors)
    return now.as_sure(model)


def recalibrated(model: Calibrated, blocks: Sequence[Block]) -> Calibrated:
    """The base model fitted to the same runs anew, from its values on; they carry other payloads
    now."""
    now = about_known(model.base, blocks, model.fitted, model.noise, (), model.errors)
    rubbed = with_friction(now)
    left = rubbed.residual(rubbed.regression.q)
    rubbed = rubbed.doubted(left)
    q = rubbed.regression.q
    left = rubbed.residual(q)
    noise = unweighted(measured(blocks, left), model.noise.white)
    again = about_known(model.base, blocks, _moved(rubbed, q), noise, (), model.errors)
    return replace(again, off=model.off).doubted(left)


def _weighted(
    model: Calibrated, noise: Noise, given: Sequence[Array], sure: Calibrated | None = None
) -> Calibrated:
    """The base model and friction fitted from its values on, in `STEPS` steps."""
    fitted, errors = model.fitted, model.errors

    def at(values: Fitted) -> Calibrated:
        there = with_friction(about(model.base, model.blocks, values, noise, (), given, errors))
        return there if sure is None else there.as_sure(sure)

    for _ in range(STEPS):
        there = at(fitted)
        fitted = _moved(there, there.regression.q)
        there.forget()
    return at(fitted)


def _evenly(model: Calibrated, given: Sequence[Array]) -> tuple[Calibrated, Array, float]:
    """The base model and friction fitted from its values on until it has settled, each axis with a
    weight of what is left there (one on which much is lacking has no more say over what axes share
    than for itself), and the machine file's values as far off as it takes: coefficients; and by how
    much that is, as of `freely`.
    """
    count, noise = len(model.base.linear), model.noise
    free, off = freely(model.regression, count)
    for _ in range(FITS):
        values, left = _moved(model, free.q), model.residual(free.q)
        even = _even(replace(model, noise=noise), left)
        later = abs(values.delay - model.fitted.delay) / values.late
        heavier = np.abs(np.log(even.scale / model.noise.scale)).max()
        if max(heavier, later, values.wider(model.fitted)) < SETTLED:
            break
        # the rows so far, before those with other weights
        model.forget()
        del free
        there = about(model.base, model.blocks, values, even, (), given, model.errors)
        model = with_friction(there).doubted(left)
        free, off = freely(model.regression, count)
    return model, free.q, off


def _even(model: Calibrated, left: Sequence[Array]) -> Noise:
    """The noise, of each axis as many times larger as the model leaves more (m, n) [N m] of it than
    of the axis that it explains best, each relative to its noise."""
    white = [model.white(i, [own[:, i] for own in left]) for i in range(model.base.n)]
    size = np.array([max(float(np.sqrt((own**2).mean())), 1.0) for own in white])
    return replace(model.noise, scale=model.noise.scale * size / size.min())


def beside(fit: Joint) -> Calibrated:
    """The base model fitted anew beside effects: what they took from it, they give back.

    A hysteresis fitted to its own torque and that of a friction has the width of neither. Friction
    that was not found, or not yet, looks like a delay here, too, and stands beside them. A delay
    that was held has its tolerance. Where columns hardly repeat between passes a fit with more of
    them may lead anywhere: if it leaves more than before the base model stays.
    """
    model, late = fit.bench.model, _tolerance(fit.bench.model.base, fit.bench.model.blocks)
    losses = losses_of(fit)
    if model.fitted.late < late or np.any(losses != model.fitted.losses):
        free = replace(model.fitted, late=max(late, model.fitted.late), losses=losses)
        now = about_known(model.base, model.blocks, free, model.noise, (), model.errors)
        model = now.as_sure(model)
    model = replace(model, fitted=replace(model.fitted, effects=effects_of(fit)))
    most = MISLED * axis_rms(model.blocks, fit.residual)
    for _ in range(STEPS_BESIDE):
        there = fit.bench.beside(with_friction(model))
        rubbed = again(fit, there)
        if (axis_rms(model.blocks, rubbed.residual) > most).any():
            return fit.bench.model
        fitted = _moved(there.model, rubbed.q, STRIDE)
        for rows in (there, there.model, model):
            rows.forget()
        now = about_known(model.base, model.blocks, fitted, model.noise, (), model.errors)
        before, model = model.fitted, now.as_sure(model)
        if fitted.wider(before) < SETTLED:
            break
    if not model.noise.repeats:
        # what the search has not found yet would count as noise; the first fit had friction
        return model
    last = again(fit, fit.bench.beside(model))
    left, fitted = last.residual, replace(model.fitted, effects=effects_of(last))
    noise = measured(model.blocks, left)
    # the rows and columns so far, before those with the new noise
    model.forget()
    fit.bench.forget()
    now = replace(model, fitted=fitted, noise=unweighted(noise, model.noise.white))
    return replace(now, noise=_even(now, left)).doubted(left)


def losses_of(fit: Joint) -> Array:
    """Shares (n,) of the reported torques that the joints do not get."""
    losses = np.zeros(fit.bench.n)
    for part, gains in zip(fit.parts, fit.beta, strict=True):
        if part.axis is not None and fit.bench.effects[part.id].effect.loses:
            losses[part.axis] = gains[0]
    return losses


def effects_of(fit: Joint) -> tuple[FixedEffect, ...]:
    """Effects that drives report the torques of, but for what the fit is linear about."""
    effects, known = list[FixedEffect](), fit.bench.effects
    for part, gains in zip(fit.parts, fit.beta, strict=True):
        if part.axis is None or part.id not in known:
            continue
        item = known[part.id]
        if item.effect.acts_on != "measurement" and not (item.effect.loses or item.effect.line):
            effects.append(FixedEffect(item, part.axis, part.shape, gains))
    return tuple(effects)


def _moved(model: Calibrated, q: Array, stride: float = np.inf) -> Fitted:
    """The values after one Gauss-Newton step, to the coefficients q, kept within bounds.

    stride: largest step of a width, relative.
    """
    base, now = model.base, model.fitted
    step = q * model.scale
    n_p, n_c = len(base.linear), len(base.curved)
    nominal = np.array([k.nominal for k in base.widths])
    widths = nominal + step[n_p + n_c : n_p + n_c + len(nominal)]
    p = np.array([k.nominal for k in base.linear]) + step[:n_p]
    gains = np.array([k.nominal for k in base.curved]) + step[n_p : n_p + n_c]
    most = LATEST * now.late
    delay = now.expected + float(np.clip(step[n_p + n_c + len(nominal)], -most, most))
    widths = np.clip(widths, now.widths / (1 + stride), now.widths * (1 + stride))
    widths = np.clip(widths, 0.4 * nominal, 2.5 * nominal)
    loads = {load.name: step[model.places(load)] for load in model.loads}
    return replace(now, p=p, gains=gains, widths=widths, delay=delay, loads=loads)
