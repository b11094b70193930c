"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint, again, axis_rms
from flexhex.diagnosis.base import Base
from flexhex.diagnosis.blocks import LATEST, Block, torque_at
from flexhex.diagnosis.calibrate import LOOSE, Calibrated, Fitted, about
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.known import about_known, known_torque
from flexhex.diagnosis.noise import Noise, measured, unweighted

Array = NDArray[np.float64]
STEPS = 2
"""Gauss-Newton steps."""
COARSE, FIRM = 4, 1e-9
"""Rows of which one is taken for the first guess of the delay; ridge of its fit, relative."""
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
        first_delay(base, blocks),
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


def first_delay(base: Base, blocks: Sequence[Block]) -> float:
    """Delay of the torques [s] to whole samples of the log, from which Gauss-Newton steps find the
    rest: with another one their columns are turned by a good part of a period.

    Of all delays within the tolerance the one at which the linear base model leaves least, if that
    is less than half of what it leaves without: else something else is missing.
    """
    step = max(block.run.tau.ts for block in blocks)
    most = int(LATEST * base.late)
    thin = [replace(b, at=b.at[::COARSE], usable=b.usable[::COARSE]) for b in blocks]
    scale = np.array([LOOSE * k.tolerance for k in base.linear])
    nominal = np.array([k.nominal for k in base.linear])
    scale = np.where(np.isfinite(scale), scale, 1.0)
    prior = np.diag([1.0 if np.isfinite(k.tolerance) else 0.0 for k in base.linear])
    B = np.concatenate([b.linear[::COARSE][t.usable] for b, t in zip(blocks, thin, strict=True)])
    known = [b.linear[::COARSE] @ base.loaded(nominal, b.run.payload) for b in blocks]
    size = np.maximum(B.std(axis=(0, 1)), np.finfo(float).tiny)
    weight = np.where(np.diag(prior) > 0, scale, 1.0 / size)
    left = dict[int, float]()
    for k in range(-most, most + 1):
        y = [torque_at(t, base.window, k * step) - a for t, a in zip(thin, known, strict=True)]
        rows = np.concatenate([v[t.usable] for v, t in zip(y, thin, strict=True)])
        # each axis counts by its own torque
        unit = np.maximum(rows.std(axis=0), np.finfo(float).tiny)
        C, v = (B * weight / unit[:, None]).reshape(-1, len(weight)), (rows / unit).ravel()
        G = C.T @ C + prior + FIRM * np.diag((C**2).sum(axis=0) + 1.0)
        left[k] = float(v @ v - v @ C @ np.linalg.solve(G, C.T @ v))
    best = min(left, key=lambda k: (left[k], abs(k)))
    return step * best if left[best] < left[0] / 2 else 0.0


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
    return Fitted(p, gains, np.clip(widths, 0.4 * nominal, 2.5 * nominal), delay, now.late)
