"""How long to smooth: long enough that the angles' noise does not drown the torque.

Accelerations are second differences of angles, so noise of an encoder grows with the inverse of
the window to the power 2.5. One window for torque and columns costs no bias, only what moves
faster than it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.reversals import encoder_step
from flexhex.diagnosis.runs.blocks import LEAST
from flexhex.diagnosis.runs.run import Run

Array = NDArray[np.float64]
SMALLEST_REPEATABLE = 0.002
"""Smallest repeatable residual that matters, RMS relative to the torque's. Where it says how much a
longer window may take away, halved or doubled it changes the answer of one of 54 cases."""
NOISE = 0.05
"""Largest share of the torque's RMS that noise of the angles may make."""
LONGER, LONGEST = 1.25, 8.0
"""The window grows by this factor until it is long enough, or this many times what it was."""
TWICE, GROWS, SURELY = 2.0, 1.1, 4.0
"""Under a window so many times as long a fitted inertia grows by this factor at least, by so many
standard deviations, where noise of the acceleration made it too small. A motor's logs with wrong
times have the same window with any of 1.05 to 1.5 and of 2 to 8."""
SPARE = 0.8
"""Share of a run that rows at their least number may use up; windows at its ends take some."""
SAMPLES = 50
"""Samples of a run at which the inertia is asked."""


@dataclass(frozen=True)
class Smoother:
    """Length of the window [s], and the torque RMS (n,) [N m] that noise of the angles makes
    under it where that is still too much, else zeros; text: what was done and why."""

    window: float
    left: Array
    text: str


def smoothed(base: Base, window: float) -> Base:
    """The base with this window [s]; its rows lie apart as far as before, in windows."""
    longer = copy(base)
    longer.spacing, longer.window = base.spacing * window / base.window, window
    return longer


def windows(
    model: Calibrated, usual: float, times: float, first: float | None = None
) -> Iterator[float]:
    """Longer and longer windows [s], each so many times the one before; first: default, that of
    the fit."""
    window, most = first or model.base.window, min(LONGEST * usual, _room(model))
    while LONGER * window <= most:
        window = min(times * window, most)
        yield window


def smoother(model: Calibrated, runs: Sequence[Run], usual: float) -> Smoother:
    """The shortest window, from that of the fit on, that is long enough for the angles.

    usual: the window [s] for quiet angles. Ask again after a fit under the longer one: noise of
    the accelerations makes a fitted inertia too small. Where rates were measured too nothing is
    smoothed longer: angles are not differenced then.
    """
    base = model.base
    noisy = [
        run.motion.noise for run in runs if run.motion.derived and run.motion.noise is not None
    ]
    if not noisy:
        return Smoother(base.window, np.zeros(base.n), "")
    noise, inertia = np.max(noisy, axis=0), inertia_of(model)
    step = np.max([encoder_step(run.motion.theta[run.valid]) for run in runs], axis=0)
    # the error of an encoder's step comes again, or with the other sign, in a pass that goes the
    # same way beside the first
    again = step > _apart(runs, base.window)
    most = np.maximum(np.where(again, SMALLEST_REPEATABLE / 2, NOISE) * model.torque_rms, 1e-300)
    ts, window = runs[0].motion.ts, base.window
    for longer in windows(model, usual, LONGER):
        if (noise * inertia * curvature(window, ts) <= most).all():
            break
        window = longer
    left = noise * inertia * curvature(window, ts)
    first = noise * inertia * curvature(usual, ts)
    worst = int(np.argmax(first / most))
    kind = kinds_of(base, base.n)[worst]
    length, effort = kind.unit("rad"), f"{first[worst]:.2g} {kind.unit('N m')} of its {kind.effort}"
    what = f"come in steps of {step[worst]:.2g} {length}" if step[worst] else "are noisy"
    text = (
        f"{kind.position}s of axis {worst + 1} {what}, which makes {effort}:"
        f" smoothed over {1e3 * window:.0f} ms instead of {1e3 * usual:.0f},"
        f" where it makes {left[worst]:.2g}"
    )
    return Smoother(window, np.where(left > most, left, 0.0), text)


def unknown_inertias(base: Base) -> list[int]:
    """Places in `linear` of inertias that runs alone tell."""
    kinds = kinds_of(base, base.n)
    return [
        place
        for place, known in enumerate(base.linear)
        if known.axis is not None
        and known.group == kinds[known.axis].inertia
        and np.isinf(known.tolerance)
    ]


def outgrown(model: Calibrated, again: Calibrated, usual: float) -> Smoother | None:
    """The longer window of another fit to the same runs, if under it an inertia that nobody knows
    grows: noise of an acceleration makes the inertia too small, whatever that noise is like. None
    else."""
    for place in unknown_inertias(model.base):
        known = model.base.linear[place]
        before, after = (m.fitted.p[place] for m in (model, again))
        rows = again.regression
        variance = rows.doubt[place] * rows.covariance[place, place]
        deviation = again.scale[place] * float(np.sqrt(variance))
        if after > GROWS * max(before, 0.0) and after - before > SURELY * deviation:
            window = again.base.window
            name = f"{known.group} of axis {(known.axis or 0) + 1}"
            text = (
                f"the fitted {name} is {before:.2g} {known.printed} under"
                f" {1e3 * model.base.window:.0f} ms of smoothing and {after:.2g} under"
                f" {1e3 * window:.0f}: accelerations are noisy, smoothed longer than the usual"
                f" {1e3 * usual:.0f} ms"
            )
            return Smoother(window, np.zeros(model.base.n), text)
    return None


def _room(model: Calibrated) -> float:
    """The longest window [s] under which the shortest run still has rows enough."""
    span = min(float(block.at[-1] - block.at[0]) for block in model.blocks)
    return SPARE * span / LEAST * model.base.window / model.base.spacing


def curvature(window: float, ts: float) -> float:
    """Second derivative [1/s2] of white noise of unit size, sampled every ts, under the window."""
    return float(2.0 * np.sqrt(2.0) * np.pi**2 * np.sqrt(ts / window) / window**2)


def inertia_of(model: Calibrated) -> Array:
    """Torque (n,) [N m s2/rad] of an axis for its own acceleration, the largest seen."""
    inertia = np.zeros(model.base.n)
    for block in model.blocks:
        m = block.run.motion
        part = slice(None, None, max(1, len(m.theta) // SAMPLES))
        few = Motion(m.t0, m.ts, m.theta[part], m.thetad[part], m.thetadd[part])
        level = model.base.torque(few, model.fitted.p)
        for i in range(model.base.n):
            faster = few.thetadd.copy()
            faster[:, i] += 1.0
            more = model.base.torque(replace(few, thetadd=faster), model.fitted.p)[:, i]
            inertia[i] = max(inertia[i], float(np.abs(more - level[:, i]).max()))
    return inertia


def _apart(runs: Sequence[Run], window: float) -> Array:
    """RMS (n,) [rad] by which the distance of passes of a trajectory in angle changes within a
    window [s]; infinite without passes."""
    distances: list[Array] = []
    for repeated in dict.fromkeys(run.repeated for run in runs):
        first, *others = [run for run in runs if run.repeated == repeated]
        shared = first.motion.time - first.shift
        for run in others:
            clock = run.motion.time - run.shift
            inside = (shared >= clock[0]) & (shared <= clock[-1])
            there = np.stack(
                [np.interp(shared[inside], clock, angle) for angle in run.motion.theta.T], axis=1
            )
            off = there - first.motion.theta[inside]
            off -= uniform_filter1d(off, max(1, round(window / first.motion.ts)), axis=0)
            distances.append(np.sqrt((off**2).mean(axis=0)))
    return (
        np.min(distances, axis=0) if distances else np.full(runs[0].motion.theta.shape[1], np.inf)
    )
