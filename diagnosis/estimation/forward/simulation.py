"""Simulation of measured runs from their torques, over windows that each begin anew.

A run that is integrated to its end drifts away with whatever model. So it is cut into windows; each
begins at the measured angle and rate, and how far its angles are off after some times says what a
model is worth (free-run simulation over a horizon, as system identification has it).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.estimation.forward.beside import (
    Part,
    file_parts,
    parts_of,
    through_drives,
)
from flexhex.diagnosis.estimation.forward.integrate import Windows, invertible, simulated
from flexhex.diagnosis.estimation.forward.record import Model, Simulation
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.payloads import carried
from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.smoothing import hann_weights

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
HORIZONS = (0.05, 0.2, 1.0)
"""Times after the start of a window at which errors are told [s]."""
STEP = 2e-3
"""Step [s]: a fifth of the smoothing under which the parameters were found. A quarter of it changes
errors by 7 % at most, where they are less than a thousandth of the motion."""
MOST = 40
"""Windows of all runs together, spread over them evenly; they overlap in short ones."""
FAR = 1.0
"""An axis farther from where it was measured than this times its whole range has diverged."""
SINGULAR = "the masses of the file have no forward dynamics: their mass matrix is singular"


@dataclass(frozen=True)
class _Cut:
    """Windows of a block, its parameters with the file's values and with the estimates, and the
    torques of the windows behind drives that are late."""

    block: Block
    windows: Windows
    behind: Array
    start: Array
    file: Array
    fitted: Array

    @property
    def samples(self) -> NDArray[np.int64]:
        """Of the run, at the start of each window."""
        return np.rint(self.windows.time / self.block.run.motion.ts).astype(np.int64)

    @property
    def drawn(self) -> list[int]:
        """Windows one after another, of which none begins within another."""
        chosen, length = [0], STEP * self.windows.tau.shape[1]
        for k, start in enumerate(self.start):
            if start >= self.start[chosen[-1]] + length:
                chosen.append(k)
        return chosen


def simulation(estimated: Estimated, there: Calibrated, held_out: bool) -> Simulation | None:
    """Of the runs of `there`, `held_out` or not, with the estimates and with the file's values, if
    there are any. None where the runs have no such window or the model no
    masses."""
    base, spans = there.base, [b.at[-1] - b.at[0] for b in there.blocks]
    horizons = tuple(h for h in HORIZONS if h <= max(spans))
    if len(base.curved) or not horizons:
        return None
    steps = round(horizons[-1] / STEP)
    cuts = [cut for b in there.blocks if (cut := _cut(estimated, there, b, steps, sum(spans)))]
    if not cuts or not all(invertible(base, c.fitted, c.windows.theta[:, 0]) for c in cuts):
        return None
    cuts = _limited(cuts)
    parts, left_out = parts_of(estimated)
    with_file = any(known.nominal and known.tolerance < np.inf for known in base.linear)
    why = "" if all(invertible(base, c.file, c.windows.theta[:, 0]) for c in cuts) else SINGULAR
    drives = [replace(c, windows=replace(c.windows, tau=c.behind)) for c in cuts]
    delay, files = there.fitted.delay, [c.file for c in cuts]
    told = _told(base, drives, [c.fitted for c in cuts], parts, delay)
    known = file_parts(estimated)
    before = _told(base, cuts, files, known, delay) if with_file and not why else None
    still = [_still(c.windows) for c in cuts]
    first = cuts[0]
    return Simulation(
        units_of(base, base.n, "rad"),
        horizons,
        STEP,
        sum(len(c.start) for c in cuts),
        held_out,
        _model(cuts, still),
        None if before is None else _model(cuts, before),
        _model(cuts, told),
        first.block.run.name,
        _broken((first.start[first.drawn, None] + STEP * np.arange(steps + 1))[:, :, None])[:, 0],
        _broken(first.windows.theta[first.drawn]),
        tuple(left_out),
        why if with_file else "",
        not estimated.extras.file,
    )


def _cut(
    estimated: Estimated, there: Calibrated, block: Block, steps: int, whole: float
) -> _Cut | None:
    """Windows of a run, as many as its share of the `whole` time [s]; those with a gap are left
    out."""
    run, base, length = block.run, there.base, steps * STEP
    motion, tau = run.motion, run.tau
    first, last = block.at[0] + run.shift, block.at[-1] + run.shift
    room = last - first - length
    if room < 0:
        return None
    count = max(1, int(min(1 + room // HORIZONS[0], MOST * (last - first) // whole)))
    start = np.linspace(first, last - length, count)
    offset = STEP * np.arange(steps + 1)
    at = start[:, None] + offset

    def seen(values: Array, at: Array) -> tuple[Array, Mask]:
        w, good = hann_weights(at.ravel(), motion.t0, motion.ts, run.valid, base.window)
        filled: Mask = np.asarray(good.reshape(at.shape).all(axis=1))
        return (w @ values).reshape(*at.shape, -1), filled

    theta, good = seen(motion.theta, at)
    thetad, _ = seen(motion.thetad, start[:, None])
    middle = (at[:, :-1] + STEP / 2 + there.fitted.delay).ravel()
    w, felt = hann_weights(middle, tau.t0, tau.ts, tau.valid, 2 * STEP)
    values = through_drives(estimated, tau.values, tau.ts)
    torque, behind = ((w @ v).reshape(count, steps, -1) for v in (tau.values, values))
    good &= felt.reshape(count, steps).all(axis=1)
    if not good.any():
        return None
    windows = Windows(theta[good], thetad[good, 0], torque[good], torque[good],
                      start[good] - motion.t0, np.zeros(base.n), STEP)  # fmt: skip
    loads = {load.name: estimated.values[there.places(load)] for load in there.loads}
    p = estimated.values[: len(base.linear)]
    nominal = np.array([known.nominal for known in base.linear])
    fitted = carried(base, there.loads, loads, run, p)
    return _Cut(
        block, windows, behind[good], start[good], base.loaded(nominal, run.payload), fitted
    )


def _limited(cuts: Sequence[_Cut]) -> list[_Cut]:
    """With how far each axis may go before it has diverged."""
    every = np.concatenate([c.windows.theta.reshape(-1, c.windows.theta.shape[2]) for c in cuts])
    widest = FAR * np.maximum(np.ptp(every, axis=0), np.finfo(float).tiny)
    return [replace(c, windows=replace(c.windows, widest=widest)) for c in cuts]


def _told(
    base: Base,
    cuts: Sequence[_Cut],
    parameters: Sequence[Array],
    parts: Sequence[Part],
    delay: float,
) -> list[Array]:
    """Angles of each cut; delay [s] of the torques. Runs with the same parameters go together,
    which is faster."""
    groups, told = dict[bytes, list[int]](), dict[int, Array]()
    for k, p in enumerate(parameters):
        groups.setdefault(p.tobytes(), []).append(k)
    for places in groups.values():
        own = [cuts[k] for k in places]
        states = [
            np.concatenate([part.along(c.block.run, base.window, delay)[c.samples] for c in own])
            for part in parts
        ]
        windows = _joined([c.windows for c in own])
        angles = simulated(base, parameters[places[0]], parts, states, windows)
        edges = np.cumsum([len(c.start) for c in own])[:-1]
        told.update(zip(places, np.split(angles, edges), strict=True))
    return [told[k] for k in range(len(cuts))]


def _joined(listed: Sequence[Windows]) -> Windows:
    first, *_ = listed
    theta, thetad, tau, reported, time = (
        np.concatenate([getattr(w, name) for w in listed])
        for name in ("theta", "thetad", "tau", "reported", "time")
    )
    return Windows(theta, thetad, tau, reported, time, first.widest, first.dt)


def _still(windows: Windows) -> Array:
    """The rate at the start of each window goes on."""
    offset = windows.dt * np.arange(windows.theta.shape[1])
    return np.asarray(windows.theta[:, :1] + windows.thetad[:, None] * offset[:, None])


def _model(cuts: Sequence[_Cut], told: Sequence[Array]) -> Model:
    off = np.concatenate([t - c.windows.theta for t, c in zip(told, cuts, strict=True)])
    rms = np.sqrt((off**2).mean(axis=0))
    gone = np.isnan(off).any(axis=2)
    first = STEP * float(np.argmax(gone.any(axis=0))) if gone.any() else np.nan
    return Model(rms, int(gone.any(axis=1).sum()), first, _broken(told[0][cuts[0].drawn]))


def _broken(values: Array) -> Array:
    """Windows (windows, steps, n) one after another, with a gap between two."""
    gap = np.full((len(values), 1, values.shape[2]), np.nan)
    return np.concatenate([values, gap], axis=1).reshape(-1, values.shape[2])[:-1]
