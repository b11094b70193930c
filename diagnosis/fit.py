"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint, again, axis_rms
from flexhex.diagnosis.base import Base
from flexhex.diagnosis.blocks import LATEST, Block
from flexhex.diagnosis.calibrate import Calibrated, Fitted, about
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.known import about_known, known_torque
from flexhex.diagnosis.noise import Noise, measured, unweighted

Array = NDArray[np.float64]
STEPS = 2
"""Gauss-Newton steps."""
MISLED = 1.5
"""Ratio of what is left of an axis' torque, weighted by its noise against not weighted, beyond
which the weights do harm."""
STEPS_BESIDE, STRIDE, SETTLED = 6, 0.4, 0.02
"""Beside effects: most steps, the longest of a width, and when it has settled; both relative."""


def calibrate(base: Base, blocks: Sequence[Block]) -> Calibrated:
    """Fit the base model: the linear part, then widths and delay by Gauss-Newton.

    What the effects that the model has already explain is taken off first.
    """
    fitted = Fitted(
        np.array([k.nominal for k in base.linear]),
        np.array([k.nominal for k in base.curved]),
        np.array([k.nominal for k in base.widths]),
        0.0,
        base.late * max(block.run.tau.ts for block in blocks),
    )
    flat = Noise(np.zeros((base.n, 2)), np.ones(base.n), np.ones(base.n), False)
    made = about(base, blocks, fitted, flat)
    given = known_torque(made)
    plain = made.residual(made.regression.q)
    noise = measured(blocks, plain)
    made = _weighted(base, blocks, fitted, noise, given)
    left = made.residual(made.regression.q)
    misled = axis_rms(blocks, left) > MISLED * axis_rms(blocks, plain)
    if misled.any():
        made = _weighted(base, blocks, fitted, unweighted(noise, misled), given)
        left = made.residual(made.regression.q)
    return replace(made, noise=unweighted(measured(blocks, left), misled))


def _weighted(
    base: Base, blocks: Sequence[Block], fitted: Fitted, noise: Noise, given: Sequence[Array]
) -> Calibrated:
    """The base model fitted from given values on, in `STEPS` steps."""
    for _ in range(STEPS):
        made = about(base, blocks, fitted, noise, given=given)
        fitted = _moved(made, made.regression.q)
    return about(base, blocks, fitted, noise, given=given)


def beside(held: Joint) -> Calibrated:
    """The base model fitted anew beside effects: what they took from it, they give back.

    A hysteresis fitted to its own torque and that of a friction has the width of neither.
    """
    made = held.bench.made
    for _ in range(STEPS_BESIDE):
        before = made.fitted
        fitted = _moved(made, held.q, STRIDE)
        made.forget()
        made = about_known(made.base, made.blocks, fitted, made.noise)
        held = again(held, Bench(made, list(held.bench.effects.values())))
        if np.abs(np.log(fitted.widths / before.widths)).max(initial=0.0) < SETTLED:
            break
    noise = measured(made.blocks, held.residual)
    return replace(made, noise=unweighted(noise, made.noise.white))


def _moved(made: Calibrated, q: Array, stride: float = np.inf) -> Fitted:
    """The values after one Gauss-Newton step, to the coefficients q, kept within bounds.

    stride: largest step of a width, relative.
    """
    base, now = made.base, made.fitted
    step = q * made.scale
    n_p, n_c = len(base.linear), len(base.curved)
    nominal = np.array([k.nominal for k in base.widths])
    widths = nominal + step[n_p + n_c : n_p + n_c + len(nominal)]
    p = np.array([k.nominal for k in base.linear]) + step[:n_p]
    gains = np.array([k.nominal for k in base.curved]) + step[n_p : n_p + n_c]
    most = LATEST * now.late
    delay = float(np.clip(step[n_p + n_c + len(nominal)], -most, most))
    widths = np.clip(widths, now.widths / (1 + stride), now.widths * (1 + stride))
    widths = np.clip(widths, 0.4 * nominal, 2.5 * nominal)
    return Fitted(p, gains, widths, delay, now.late, _payloads(made, step))


def _payloads(made: Calibrated, step: Array) -> dict[str, Array]:
    """What each payload adds to the linear parameters, by its name."""
    found: dict[str, Array] = {}
    end = len(made.known)
    for load in reversed(made.loads):
        found[load.name] = step[end - len(load.known) : end]
        end -= len(load.known)
    return found
