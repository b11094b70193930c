"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.guess import first_guess
from flexhex.diagnosis.jointfit.known import about_known, known_torque
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.jointfit.values import (
    at_values,
    evenly_noisy,
    tolerance_of_delay,
    values_after,
)
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.linearize import about
from flexhex.diagnosis.runs.blocks import Block
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
SETTLED = 0.02
"""Change of widths and weights, relative, and of the delay, in tolerances, below which a fit has
settled."""


def calibrate(base: Base, blocks: Sequence[Block]) -> Calibrated:
    """Fit the base model: the linear part, then widths and delay by Gauss-Newton.

    What the effects that the model has already explain is taken off first. Friction that it does
    not have looks like a delay: so delay and noise are those beside one. A delay beyond its
    tolerance that does not explain much of what is left is bent by what is missing: then the model
    stands about none, as free as ever, for the effects that are found to say.
    """
    late = tolerance_of_delay(base, blocks)
    model, left = _calibrated(base, blocks, late)
    if abs(model.fitted.delay) <= late:
        return model
    without, most = _calibrated(base, blocks, HELD * late)
    if np.prod((left / most) ** 2) < EXPLAINED:
        return model
    return at_values(without, replace(without.fitted, late=late))


def _calibrated(base: Base, blocks: Sequence[Block], late: float) -> tuple[Calibrated, Array]:
    """The same with a tolerance of the delay [s], and the RMS (n,) [N m] that is left of each axis
    beside friction."""
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
    model = replace(model, noise=evenly_noisy(model, left))
    return replace(model, off=off).doubted(left), axis_rms(blocks, left)


def held(model: Calibrated, delay: float, lag: float = 0.0) -> Calibrated:
    """The base model with a delay of the torques [s] and no freedom for another one; lag: about
    which one of the drive is taken [s]."""
    late = HELD * tolerance_of_delay(model.base, model.blocks)
    return at_values(model, replace(model.fitted, delay=delay, expected=delay, late=late, lag=lag))


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
    again = about_known(model.base, blocks, values_after(rubbed, q), noise, (), model.errors)
    again = replace(again, noise=evenly_noisy(again, left))
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
        fitted = values_after(there, there.regression.q)
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
        before = model.fitted
        values, left = values_after(model, free.q), model.residual(free.q)
        even = evenly_noisy(replace(model, noise=noise), left)
        heavier = np.abs(np.log(even.scale / model.noise.scale)).max()
        if max(heavier, values.later(before), values.wider(before)) < SETTLED:
            break
        # the rows so far, before those with other weights
        model.forget()
        del free
        there = about(model.base, model.blocks, values, even, (), given, model.errors)
        model = with_friction(there).doubted(left)
        free, off = freely(model.regression, count)
    return model, free.q, off
