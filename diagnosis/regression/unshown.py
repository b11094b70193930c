"""Fast accelerations that the torque does not show: those of wrong times, held samples or noise.

Where a logger stamps samples that come late, or holds one and skips the next, angles and rates
jump. That is no white noise, and differences make large accelerations of it. The file's inertias
say what torque these take, and the drive did not report it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.window import NOISE, TWICE, Smoother, windows
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.smoothing import hann_weights

Array = NDArray[np.float64]
ALIKE = 0.5
"""Squared correlation of two fast torques from which they are the same but for a factor. A Panda's
log with wrong times has the same window with any of 0.1 to 1."""


def quiet(model: Calibrated, runs: Sequence[Run], usual: float) -> Smoother | None:
    """The shortest window, from the usual one on twice as long each time, under which no axis has
    fast accelerations that its torque does not show, or the longest one; None where that of the fit
    is as long.

    Noise that is white in the accelerations falls with the root of the window, and noise of angles
    faster: what does not is a motion of which the file is wrong.
    """
    base, rms = model.base, model.torque_rms
    torques, window = [_torque(base, run) for run in runs], usual
    made = first = _unshown(runs, torques, window)
    noisy = made > NOISE * rms
    for longer in windows(model, usual, TWICE, usual):
        if not (made > NOISE * rms)[noisy].any():
            break
        after = _unshown(runs, torques, longer)
        noisy &= after <= made * (window / longer) ** 0.5
        if not noisy.any():
            break
        window, made = longer, after
    if window <= base.window:
        return None
    first = np.where(noisy, first, 0.0)
    worst = int(np.argmax(first / np.maximum(rms, np.finfo(float).tiny)))
    kind = kinds_of(base, base.n)[worst]
    text = (
        f"fast accelerations of axis {worst + 1} would take {first[worst]:.2g} {kind.unit('N m')}"
        f" that its {kind.effort} does not show: wrong times, held samples or noise make them;"
        f" smoothed over {1e3 * window:.0f} ms instead of {1e3 * usual:.0f}"
    )
    return Smoother(window, np.zeros(base.n), text)


def _unshown(runs: Sequence[Run], torques: Sequence[Array], window: float) -> Array:
    """RMS (n,) [N m] of the model's torque (samples, n) of each run that a window [s] lets through
    and one twice as long does not; zero where that of the drive is nearer to it than to nothing,
    or goes with it, as where a mechanism swings."""
    model, drive, both, count = 0.0, 0.0, 0.0, 0
    for run, torque in zip(runs, torques, strict=True):
        of_model, of_drive = _fast(run, torque, window)
        model, drive = model + (of_model**2).sum(axis=0), drive + (of_drive**2).sum(axis=0)
        both, count = both + (of_model * of_drive).sum(axis=0), count + len(of_model)
    shown = (model <= 2 * both) | (both**2 >= ALIKE * model * drive)
    return np.where(shown, 0.0, np.sqrt(model / max(count, 1)))


def _fast(run: Run, torque: Array, window: float) -> Iterator[Array]:
    """Of the model's torque (samples, n) and of the drive's what a window lets through and one
    twice as long does not (m, n)."""
    motion, tau, longer = run.motion, run.tau, TWICE * window
    start = max(motion.t0, tau.t0)
    end = min(motion.time[-1], tau.t0 + tau.ts * (len(tau.valid) - 1))
    at, there = np.arange(start + longer, end - longer, window / 2), list[Array]()
    filled = np.ones(len(at), dtype=bool)
    for clock, valid, values in ((motion, run.valid, torque), (tau, tau.valid, tau.values)):
        means = []
        for length in (window, longer):
            weights, full = hann_weights(at, clock.t0, clock.ts, valid, length)
            means.append(np.asarray(weights @ values))
            filled &= full
        there.append(means[0] - means[1])
    return (own[filled] for own in there)


def _torque(base: Base, run: Run) -> Array:
    """What the values of the machine file take for a motion (samples, n) [N m]."""
    return base.torque(run.motion, np.array([known.nominal for known in base.linear]))
