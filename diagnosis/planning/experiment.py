"""The experiment that an effect asks for, as a motion any machine can follow.

The motions are those of the reference block: the same equations, the same seeded numbers. One pass
begins and ends at rest at the same place, so that it can be repeated as often as wanted.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex import fmus
from flexhex.diagnosis.kinds import Kinds, kinds_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.planning.trajectory import Trajectory, extremes, write_trajectory
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.fmus.common.effects import Experiment, library
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.reference.equations import (
    MAX_SINES,
    chirp,
    derived,
    fading,
    multisine,
    transition,
    triangle,
    triangle_times,
)
from flexhex.numeric.library import loaded, pointer

Array = NDArray[np.float64]
Setpoints = tuple[Array, Array, Array]
"""r, rd, rdd, each (samples, n)."""
_UNIFORMS = """
void uniforms(double seed, long count, double *values) {
  for (long k = 0; k < count; ++k) { values[k] = uniform(seed, (double)k); }
}
"""
DEFAULTS: Mapping[str, float] = {
    "seed": 1,
    "duration": 50.0,
    "passes": 2,
    "period": 1.0,
    "move": 0.6,
    "speed": 0.05,
    "rounding": 1.0,
    "fade": 1.0,
    "f_base": 0.1,
    "n_sines": 10,
    "f0": 0.1,
    "f1": 3.0,
}
"""As the reference block has them; two passes are what shows what repeats."""
BEFORE, AFTER = 2.0, 1.0
"""Rest [s] before and after the motion."""
USED = 0.95
"""Part of the allowed angles, speeds and accelerations that a motion uses."""
LONGEST = 4.0
"""Durations that one cycle of a slow triangle may take."""
CHANGED = {"amplitude", "speed", "rounding", "passes"}
"""Parameters of which a file says what came of them."""
USUAL_REACH, LAG = 0.2, 0.02
"""Amplitude [rad] that the library's motions are for, an axis that slides has them in proportion;
time [s] over which the speeds and accelerations of a log are taken."""


@dataclass(frozen=True)
class Limits:
    """Where and how fast the axes may go.

    low, high (n,) [rad]; speed (n,) [rad/s]; acceleration (n,) [rad/s2]; amplitude (n,) [rad]: of a
    motion whose effect asks for none; m for rad where an axis slides. kinds: none where all turn.
    """

    low: Array
    high: Array
    speed: Array
    acceleration: Array
    amplitude: Array
    kinds: Kinds = ()

    @classmethod
    def of_machine(cls, machine: Machine) -> Limits:
        """The stroke; fast motions are limited by what the effects ask for."""
        ones = np.ones(machine.n_arms)
        stroke, free = machine.geometry.stroke * ones, np.inf * ones
        return cls(-stroke, stroke, free, free, machine.reference.amplitude * ones)

    @classmethod
    def of_logs(cls, logs: Sequence[Log]) -> Limits:
        """What measured runs have shown to be possible: no angle, speed, acceleration beyond."""
        lows, highs, speeds, accelerations = zip(*map(_seen, logs), strict=True)
        low, high = np.min(lows, axis=0), np.max(highs, axis=0)
        fastest, hardest = np.max(speeds, axis=0), np.max(accelerations, axis=0)
        return cls(low, high, fastest, hardest, 0.5 * (high - low), logs[0].kinds)

    @property
    def middle(self) -> Array:
        """Where a motion begins and ends (n,) [rad]."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> Array:
        """Largest amplitude (n,) [rad]."""
        return USED * 0.5 * (self.high - self.low)

    @property
    def size(self) -> Array:
        """Lengths (n,) of the library's motions on each axis, relative to its angles."""
        turn = [k.turns for k in kinds_of(self, len(self.low))]
        return np.where(turn, 1.0, self.reach / USUAL_REACH)


def _seen(log: Log) -> tuple[Array, Array, Array, Array]:
    """Extremes of angle, speed and acceleration (n,) in the good stretches of a log."""
    channel = log["theta"]
    lag = max(1, round(LAG / channel.ts))
    theta = np.where(channel.valid[:, None], channel.values, np.nan)
    rate = (theta[lag:] - theta[:-lag]) / (lag * channel.ts)
    change = (rate[lag:] - rate[:-lag]) / (lag * channel.ts)
    speed, acceleration = (np.nanmax(np.abs(v), axis=0, initial=0.0) for v in (rate, change))
    return np.nanmin(theta, axis=0), np.nanmax(theta, axis=0), speed, acceleration


def make(spec: Experiment, limits: Limits, ts: float = 0.25e-3, name: str = "next") -> Trajectory:
    """One pass of an experiment within the limits, a sample every ts [s]; UsageError if unknown."""
    if spec.kind not in MOTIONS:
        raise UsageError(f"{spec.kind!r} is no kind of experiment, there are {', '.join(MOTIONS)}")
    given = {**DEFAULTS, **spec.parameters}
    amplitude = given["amplitude"] * limits.size if "amplitude" in given else limits.amplitude
    r, rd, rdd = MOTIONS[spec.kind](given, np.minimum(amplitude, limits.reach), limits, ts)
    moved = np.pad(r, ((round(BEFORE / ts), round(AFTER / ts)), (0, 0))) + limits.middle
    meta = {"trajectory": name, "kind": spec.kind}
    meta |= {key: f"{value:g}" for key, value in spec.parameters.items() if key not in CHANGED}
    meta |= {**extremes((r, rd, rdd), limits), "passes": f"{given['passes']:g}"}
    if spec.payload:
        meta["payloads"] = ", ".join(f"{mass:g} kg" for _, mass in spec.payload)
    return Trajectory(name, ts, np.round(moved, 10), meta, limits.kinds)


def _scaled(unit: Setpoints, wanted: Array, limits: Limits) -> Setpoints:
    """A motion of amplitude one (samples, n) as large as wanted and allowed."""
    _, rate, change = (np.maximum(np.abs(v).max(axis=0), 1e-300) for v in unit)
    bounds = [wanted, USED * limits.speed / rate, USED * limits.acceleration / change]
    amplitude = np.min(bounds, axis=0)
    r, rd, rdd = (amplitude * v for v in unit)
    return r, rd, rdd


def _random(given: Mapping[str, float], wanted: Array, limits: Limits, ts: float) -> Setpoints:
    """Setpoints within +-amplitude, one each period, the last one zero."""
    steps, n = round(given["period"] / ts), len(wanted)
    moves = max(2, int(given["duration"] / given["period"] + 1e-9))
    drawn = uniform(int(given["seed"]), n * (moves - 1)).reshape(-1, n)
    points = np.concatenate([np.zeros((1, n)), 2 * drawn - 1, np.zeros((1, n))])
    t = ca.SX.sym("t")
    share = ca.if_else(t < given["move"], transition(t / given["move"]), 1)
    parts = _along(t, derived(share, t), ts * np.arange(steps))
    derivatives = [np.einsum("s,mn->msn", p[:, 0], np.diff(points, axis=0)) for p in parts]
    derivatives[0] += points[:-1, None, :]
    r, rd, rdd = (v.reshape(-1, n) for v in derivatives)
    return _scaled((r, rd, rdd), wanted, limits)


def _triangle(given: Mapping[str, float], wanted: Array, limits: Limits, ts: float) -> Setpoints:
    """Whole cycles at one speed; slower where the corners have no room, smaller where one cycle
    would take more than LONGEST durations."""
    rounding = np.minimum(given["rounding"] * limits.size, USED * limits.acceleration)
    speed = np.minimum(given["speed"] * limits.size, USED * limits.speed)
    # a half of `longest` between the corners and a third of it in them
    eighth = LONGEST * given["duration"] / 8
    reach = np.min([wanted, speed * eighth, USED * rounding * eighth**2], axis=0)
    speed = np.minimum(speed, np.sqrt(USED * rounding * reach))
    shapes = [
        (a, v, c) if a > 0 else (0.0, 1.0, 1.0)
        for a, v, c in zip(reach, speed, rounding, strict=True)
    ]
    times = [[float(s) for s in triangle_times(*shape)] for shape in shapes]
    duration = max(given["duration"], np.ceil(max(map(sum, times))))
    t, time = ca.SX.sym("t"), ts * np.arange(round(duration / ts))
    cycles_of: dict[tuple[float, ...], list[Array]] = {}
    for shape, (cycle, extra) in zip(shapes, times, strict=True):
        if shape not in cycles_of:
            cycles = np.floor((duration - extra) / cycle) if shape[0] else 0.0
            cycles_of[shape] = _along(t, list(triangle(t, *map(ca.SX, (cycles, *shape)))), time)
    r, rd, rdd = (np.hstack([cycles_of[shape][k] for shape in shapes]) for k in range(3))
    return r, rd, rdd


def _multisine(given: Mapping[str, float], wanted: Array, limits: Limits, ts: float) -> Setpoints:
    """Mean of sines with phases of their own on every axis, faded in and out."""
    phases = 2 * np.pi * uniform(int(given["seed"]), len(wanted) * MAX_SINES)
    t, time = ca.SX.sym("t"), ts * np.arange(round(given["duration"] / ts))
    fade = fading(t, ca.SX(given["duration"]), ca.SX(given["fade"]))
    base, count = ca.SX(given["f_base"]), ca.SX(given["n_sines"])
    waves = [multisine(t, base, count, ca.SX(p)) for p in phases.reshape(-1, MAX_SINES)]
    axes = [_along(t, derived(fade * wave, t), time) for wave in waves]
    r, rd, rdd = (np.hstack(parts) for parts in zip(*axes, strict=True))
    return _scaled((r, rd, rdd), wanted, limits)


def _chirp(given: Mapping[str, float], wanted: Array, limits: Limits, ts: float) -> Setpoints:
    """One sine of rising frequency on all axes, faded in and out."""
    t, T = ca.SX.sym("t"), ca.SX(given["duration"])
    sweep = fading(t, T, ca.SX(given["fade"])) * chirp(t, T, ca.SX(given["f0"]), ca.SX(given["f1"]))
    time = ts * np.arange(round(given["duration"] / ts))
    parts = _along(t, derived(sweep, t), time)
    r, rd, rdd = (np.tile(part, (1, len(wanted))) for part in parts)
    return _scaled((r, rd, rdd), wanted, limits)


MOTIONS = {"random": _random, "triangle": _triangle, "multisine": _multisine, "chirp": _chirp}


def _along(t: ca.SX, values: Sequence[ca.SX], time: NDArray[Any]) -> list[Array]:
    """Values (samples, 1) of expressions of t [s]."""
    function = ca.Function("along", [t], [ca.cse(ca.densify(v)) for v in values])
    return [np.asarray(v, dtype=np.float64).T for v in function.call([ca.DM(time).T])]


def uniform(seed: int, count: int) -> Array:
    """First doubles in [0, 1) (count,) of the reference block's generator, its own C."""
    header = Path(fmus.__path__[0], "reference", "splitmix64.h").read_text(encoding="utf-8")
    library = loaded(header + _UNIFORMS, "splitmix64")
    values = np.empty(count)
    library.uniforms(ctypes.c_double(seed), ctypes.c_long(count), pointer(values))
    return values


def with_experiments(
    diagnosis: Diagnosis, limits: Limits, folder: Path, ts: float = 0.25e-3
) -> Diagnosis:
    """The same diagnosis; effects with rivals name the file of the experiment that separates them,
    FOLDER/next-ID.csv, which this writes."""
    effects = []
    for effect in diagnosis.effects:
        if effect.rivals and effect.id in library():
            trajectory = make(library()[effect.id].spec, limits, ts, f"next-{effect.id}")
            path = write_trajectory(trajectory, folder / f"{trajectory.name}.csv")
            effect = replace(effect, experiment=str(path))
        effects.append(effect)
    return replace(diagnosis, effects=tuple(effects))
