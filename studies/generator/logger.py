"""What the logger makes of a run: noise, steps, hold, delay, dropped samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from studies.generator.draw import Case
from studies.generator.inverse import Clean
from studies.generator.trajectories import RATE, WARM
from tests.oracles.calculus import Array

UNITS = {"theta": "rad", "tau_meas": "N m", "tau": "N m", "r": "rad"}


@dataclass(frozen=True)
class Run:
    """A log: time (samples,) [s], channels (samples, 6) by name, metadata."""

    time: Array
    channels: dict[str, Array]
    meta: dict[str, str]
    held_out: bool

    @property
    def name(self) -> str:
        """Name of its file without ending."""
        return f"run{int(self.meta['run']):02d}"


def logged(case: Case, clean: Clean) -> list[Run]:
    """All runs of a case as they are written down, in the order in which they were made."""
    rng = np.random.default_rng([case.noise.seed, 2])
    runs = []
    for k in range(clean.clock.shape[0]):
        letter, number = divmod(k, case.passes)
        meta = {
            "run": str(k + 1),
            "trajectory": chr(ord("a") + letter),
            "pass": str(number + 1),
            "payload": "0",
        }
        time, channels = _read(case, clean, k, rng)
        runs.append(Run(time, channels, meta, letter == len(case.trajectories) - 1))
    return runs


def _read(
    case: Case, clean: Clean, k: int, rng: np.random.Generator
) -> tuple[Array, dict[str, Array]]:
    """Time and channels (samples, 6) of run k.

    The drives hold a torque over a sample, so that what is read belongs half a sample earlier
    (the closed loop has this in it); the delay of the logger is that of both torque channels.
    """
    log, clock = case.log, clean.clock[k]
    first = round(WARM * RATE)
    late = (log.delay + (0.0 if case.closed else 0.5)) / RATE

    def torque(signal: Array) -> Array:
        return np.asarray(CubicSpline(clock, signal[:, k], axis=-1)(clock[first:] - late))

    noise = case.noise.white * rng.standard_normal((6, clock.size - first))
    channels = {
        "theta": _stepped(clean.q[:, k, first:], log.angle_step),
        "tau_meas": _stepped(torque(clean.i) + noise, log.torque_step),
        "tau": _stepped(torque(clean.tau), log.torque_step),
        "r": clean.r[:, k, first:],
    }
    kept = rng.random(clock.size - first) >= log.dropped
    time = np.arange(clock.size - first) / RATE
    return time[kept], {name: values.T[kept] for name, values in channels.items()}


def _stepped(signal: Array, step: float) -> Array:
    return np.asarray(np.round(signal / step) * step)
