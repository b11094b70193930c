"""What an effect of this family is: a formula that is applied to the machine, or a change of its
MuJoCo model; and how large it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from studies.mujoco.machine import Array, Machine, Parts


@dataclass(frozen=True)
class Motion:
    """A run without the effect: time (samples,) [s]; position, rate, acceleration, torque
    (samples, n)."""

    t: Array
    q: Array
    v: Array
    a: Array
    tau: Array

    def rms(self) -> Array:
        """Torque RMS (n,) [N m] or [N]."""
        return np.asarray(np.sqrt(np.mean(self.tau**2, axis=0)))


class Effect:
    """An effect on some axes.

    id: in the library, or a name of its own. accept: ids that are right, none outside the library.
    axes: from 0. place: `force` (the joint needs `gain * unit` more), `drive` (the motor
    reports that much more than the joint gets), `reading` (the encoder reads that much more),
    `model` (it is in the MuJoCo model). gain (axes,): zero until `size` sets it. units, gains:
    of the library's parameters, for the truth.
    """

    place = "force"
    whole = False
    """Whether `at` wants positions, rates and torques of all axes."""

    def __init__(self, id: str, axes: tuple[int, ...], accept: tuple[str, ...] | None = None):
        self.id, self.axes = id, axes
        self.accept = (id,) if accept is None else accept
        self.accept_axes = axes
        self.gain = np.zeros(len(axes))
        self.shapes: dict[str, tuple[Any, str]] = {}
        self.parameter, self.unit = "gain", "1"

    def reset(self, step: float) -> None:
        """Begin a run sampled every `step` [s]."""

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        """For a gain of one (axes,), of time, own positions, rates and torques (axes,)."""
        raise NotImplementedError

    def change(self, parts: Parts, machine: Machine) -> None:
        """Put an effect of place `model` into the model."""

    def size(self, motion: Motion, share: float) -> None:
        """Set the gain so that its torque is `share` of the torque RMS on each of its axes."""
        shape = self.along(motion)
        own = np.sqrt(np.mean(shape**2, axis=0))
        self.gain = share * motion.rms()[list(self.axes)] / np.maximum(own, 1e-300)

    def along(self, motion: Motion) -> Array:
        """For a gain of one along a motion (samples, axes)."""
        pick = list(range(motion.tau.shape[1])) if self.whole else list(self.axes)
        self.reset(float(motion.t[1] - motion.t[0]))
        q, v, tau = motion.q[:, pick], motion.v[:, pick], motion.tau[:, pick]
        return np.stack([self.at(float(t), *x) for t, *x in zip(motion.t, q, v, tau, strict=True)])

    def parameters(self, step: float) -> dict[str, Any]:
        """Parameters with their true values and units; step [s] of the simulation."""
        rows: dict[str, Any] = {
            self.parameter: {"value": [float(g) for g in self.gain], "unit": self.unit}
        }
        for name, (value, unit) in self.shapes.items():
            rows[name] = {"value": value, "unit": unit}
        return rows


Formula = Callable[[float, Array, Array, Array], Array]


@dataclass
class Plain:
    """What a formula without memory is made of."""

    id: str
    form: Formula
    parameter: str
    unit: str
    place: str = "force"
    accept: tuple[str, ...] | None = None
    shapes: Mapping[str, tuple[Any, str]] = field(default_factory=dict)


class Algebraic(Effect):
    """A formula of time, position, rate and torque, without memory."""

    def __init__(self, plain: Plain, axes: tuple[int, ...]):
        super().__init__(plain.id, axes, plain.accept)
        self.form, self.place = plain.form, plain.place
        self.parameter, self.unit = plain.parameter, plain.unit
        self.shapes = dict(plain.shapes)

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return self.form(t, q, v, tau)


class Dahl(Effect):
    """Hysteresis of Dahl: z' = (v - |v| z) / width, exact for a step of one sign."""

    def __init__(self, id: str, axes: tuple[int, ...], width: Array, unit: str):
        super().__init__(id, axes)
        self.width = width
        self.parameter, self.unit = "c_2", unit
        self.shapes = {"sigma_2": ([float(w) for w in width], "rad or m")}
        self.before: Array | None = None
        self.z = np.zeros(len(axes))

    def reset(self, step: float) -> None:
        self.z, self.before = np.zeros(len(self.axes)), None

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        way = np.zeros(len(self.axes)) if self.before is None else q - self.before
        sign = np.sign(way)
        self.z = sign + (self.z - sign) * np.exp(-np.abs(way) / self.width)
        self.before = q.copy()
        return self.z.copy()


class Late(Effect):
    """The joint gets the torque of some cycles before."""

    place = "drive"

    def __init__(self, axes: tuple[int, ...], seconds: float):
        super().__init__("time_delay", axes)
        self.seconds, self.parameter, self.unit = seconds, "T_delay", "s"
        self.queue: list[Array] = []

    def reset(self, step: float) -> None:
        self.queue = []
        self.count = max(1, round(self.seconds / step))

    def size(self, motion: Motion, share: float) -> None:
        """Cycles that come nearest to the share; the delay is the same on all its axes."""
        step = float(motion.t[1] - motion.t[0])
        tau = motion.tau[:, list(self.axes)]
        rate = np.sqrt(np.mean(np.gradient(tau, step, axis=0) ** 2, axis=0))
        wanted = float(np.min(share * motion.rms()[list(self.axes)] / np.maximum(rate, 1e-300)))
        self.seconds = float(np.clip(round(wanted / step), 1, 8)) * step
        self.gain = np.ones(len(self.axes))

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        self.queue.append(tau.copy())
        old = self.queue.pop(0) if len(self.queue) > self.count else self.queue[0]
        return np.asarray(tau - old)

    def parameters(self, step: float) -> dict[str, Any]:
        return {"T_delay": {"value": [self.seconds] * len(self.axes), "unit": "s"}}
