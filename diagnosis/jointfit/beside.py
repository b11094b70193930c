"""The base model fitted anew beside effects that were found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import Joint, again
from flexhex.diagnosis.jointfit.fit import MISLED, SETTLED
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.jointfit.values import (
    at_values,
    evenly_noisy,
    tolerance_of_delay,
    values_after,
)
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import FixedEffect
from flexhex.diagnosis.runs.noise import measured, unweighted

Array = NDArray[np.float64]
STEPS, STRIDE = 6, 0.4
"""Most steps, and the longest of a width, relative."""


def beside(fit: Joint) -> Calibrated:
    """The base model fitted anew beside effects: what they took from it, they give back.

    A hysteresis fitted to its own torque and that of a friction has the width of neither. Friction
    that was not found, or not yet, looks like a delay here, too, and stands beside them. A delay
    that was held has its tolerance; one that what is missing had bent comes back in some steps.
    Where columns hardly repeat between passes a fit with more of them may lead anywhere: if it
    leaves more than before the base model stays.
    """
    model, late = fit.bench.model, tolerance_of_delay(fit.bench.model.base, fit.bench.model.blocks)
    losses = losses_of(fit)
    if model.fitted.late < late or np.any(losses != model.fitted.losses):
        model = at_values(
            model, replace(model.fitted, late=max(late, model.fitted.late), losses=losses)
        )
    model = replace(model, fitted=replace(model.fitted, effects=effects_of(fit)))
    most = MISLED * axis_rms(model.blocks, fit.residual)
    for _ in range(STEPS):
        rubbed = again(fit, fit.bench.beside(with_friction(model)))
        left = axis_rms(model.blocks, rubbed.residual)
        before, fitted = model.fitted, values_after(rubbed.bench.model, rubbed.q, STRIDE)
        for rows in (rubbed.bench, rubbed.bench.model, model):
            rows.forget()
        model = at_values(model, fitted)
        if max(fitted.wider(before), fitted.later(before)) < SETTLED:
            break
    if (left > most).any():
        return fit.bench.model
    if not model.noise.repeats:
        # what the search has not found yet would count as noise; the first fit had friction
        return model
    last = again(fit, fit.bench.beside(model))
    rest, fitted = last.residual, replace(model.fitted, effects=effects_of(last))
    noise = measured(model.blocks, rest)
    # the rows and columns so far, before those with the new noise
    model.forget()
    fit.bench.forget()
    now = replace(model, fitted=fitted, noise=unweighted(noise, model.noise.white))
    return replace(now, noise=evenly_noisy(now, rest)).doubted(rest)


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
