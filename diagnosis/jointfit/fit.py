"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.answer import Joint, again
from flexhex.diagnosis.jointfit.known import about_known, known_torque
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import friction, with_friction
from flexhex.diagnosis.regression.calibrate import Calibrated, Fitted
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.linearize import about
from flexhex.diagnosis.runs.blocks import LATEST, Block, torque_at
from flexhex.diagnosis.runs.noise import Noise, measured, unweighted

Array = NDArray[np.float64]
STEPS = 2
"""Gauss-Newton steps."""
COARSE, FIRM = 4, 1e-9
"""Rows of which one is taken for the first guess of the delay; ridge of its fit, relative."""
EXPLAINED = 0.5
"""Part of the product of the squares that all axes leave without a delay, below which it is one."""
HELD = 1e-3
"""Tolerance of a delay that is held, of the usual one."""
MISLED = 1.25
"""Ratio of what is left of an axis' torque, weighted by its noise against not weighted, beyond
which the weights do harm."""
FITS = 6
"""Fits until each axis has the weight of what is left there."""
STEPS_BESIDE, STRIDE, SETTLED = 6, 0.4, 0.02
"""Beside effects: most steps, and the longest of a width, relative; change of widths and weights,
relative, and of the delay, in tolerances, below which a fit has settled."""


def calibrate(base: Base, blocks: Sequence[Block]) -> Calibrated:
    """Fit the base model: the linear part, then widths and delay by Gauss-Newton.

    What the effects that the model has already explain is taken off first. Friction that it does
    not have looks like a delay: so delay and noise are those beside one. A delay beyond its
    tolerance that does not explain much of what is left is none.
    """
    model, left = _calibrated(base, blocks, 1.0)
    if abs(model.fitted.delay) <= model.fitted.late:
        return model
    held, most = _calibrated(base, blocks, HELD)
    return model if np.prod((left / most) ** 2) < EXPLAINED else held


def _calibrated(base: Base, blocks: Sequence[Block], share: float) -> tuple[Calibrated, Array]:
    """The same with so much of a delay's tolerance, and the RMS (n,) [N m] that is left of each
    axis beside friction."""
    late = share * base.late * max(block.run.tau.ts for block in blocks)
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


def first_guess(base: Base, blocks: Sequence[Block], late: float) -> tuple[Array, float]:
    """Linear parameters p and delay of the torques [s] to whole samples of the log, from which
    Gauss-Newton steps find the rest: with another delay their columns are turned by a good part of
    a period, and without parameters no torque says how late it is.

    Of all delays within `LATEST` tolerances, late [s], the one at which the linear base model and
    friction leave least, if that is less than half of what they leave without: else something else
    is missing.
    """
    step = max(block.run.tau.ts for block in blocks)
    most = int(LATEST * late / step)
    thin = [
        replace(b, at=b.at[::COARSE], usable=b.usable[::COARSE], moves=b.moves[::COARSE])
        for b in blocks
    ]
    scale = np.array([k.tolerance for k in base.linear])
    nominal = np.array([k.nominal for k in base.linear])
    scale = np.where(np.isfinite(scale), scale, 1.0)
    free = [1.0 if np.isfinite(k.tolerance) else 0.0 for k in base.linear]
    rubbed = friction(blocks)
    more = rubbed[0].shape[2]
    prior = np.diag([*free, *np.zeros(more)])
    few, every = slice(None, None, COARSE), range(len(nominal))
    pairs = zip(blocks, rubbed, strict=True)
    columns = [np.concatenate([b.linear.at(every, few), f[few]], axis=2) for b, f in pairs]
    B = np.concatenate([c[t.usable] for c, t in zip(columns, thin, strict=True)])
    known = [b.linear.times(base.loaded(nominal, b.run.payload), few) for b in blocks]
    size = np.maximum(B.std(axis=(0, 1)), np.finfo(float).tiny)
    weight = np.where(np.diag(prior) > 0, np.append(scale, np.ones(more)), 1.0 / size)
    left, solutions = dict[int, float](), dict[int, Array]()

    def later(k: int) -> Array:
        y = [torque_at(t, base.window, k * step) - a for t, a in zip(thin, known, strict=True)]
        return np.concatenate([v[t.usable] for v, t in zip(y, thin, strict=True)])

    # each axis counts by its own torque
    unit = np.maximum(later(0).std(axis=0), np.finfo(float).tiny)
    C = (B * weight / unit[:, None]).reshape(-1, len(weight))
    own = C.T @ C
    G = own + prior + FIRM * np.diag(np.diag(own) + 1.0)
    for k in range(-most, most + 1):
        v = (later(k) / unit).ravel()
        right = C.T @ v
        solutions[k] = np.linalg.solve(G, right)
        left[k] = float(v @ v - right @ solutions[k])
    best = min(left, key=lambda k: (left[k], abs(k)))
    best = best if left[best] < left[0] / 2 else 0
    count = len(nominal)
    return nominal + (weight * solutions[best])[:count], step * best


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
    that was not found, or not yet, looks like a delay here, too, and stands beside them.
    """
    model = fit.bench.model
    for _ in range(STEPS_BESIDE):
        there = fit.bench.beside(with_friction(model))
        fitted = _moved(there.model, again(fit, there).q, STRIDE)
        for rows in (there, there.model, model):
            rows.forget()
        now = about_known(model.base, model.blocks, fitted, model.noise, (), model.errors)
        before, model = model.fitted, now.as_sure(model)
        if fitted.wider(before) < SETTLED:
            break
    if not model.noise.repeats:
        # what the search has not found yet would count as noise; the first fit had friction
        return model
    left = again(fit, fit.bench.beside(model)).residual
    noise = measured(model.blocks, left)
    # the rows and columns so far, before those with the new noise
    model.forget()
    fit.bench.forget()
    now = replace(model, noise=unweighted(noise, model.noise.white))
    return replace(now, noise=_even(now, left)).doubted(left)


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
    return Fitted(p, gains, widths, delay, now.late, loads, now.expected)
