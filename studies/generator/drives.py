"""Effects between the command and the joint: motor, drive and encoder.

    command tau -> drive -> reported torque tau_meas -> motor -> real torque -> joint -> encoder

A motor effect makes the real torque another one than the drive reports (it knows the current
and the nominal constant only); a drive effect makes the reported torque another than the
command; an encoder effect makes the reading another than the angle. Signals are (6, runs,
samples), gains (6,) with zeros on the joints that are sound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from studies.generator.effects import Rng, column
from tests.oracles.calculus import Array


@dataclass(frozen=True)
class Motor:
    """Between reported and real torque."""

    unit: str = "1"
    limit: float = np.inf
    announced: dict[str, float] = field(default_factory=dict)
    closed = True
    everywhere = False

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        """What the drive reports where the motor gives m."""
        raise NotImplementedError

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        """What the motor gives where the drive reports i."""
        raise NotImplementedError


@dataclass(frozen=True)
class Saturating(Motor):
    """Iron saturates: m = i_s tanh(i / i_s), gain = 1 / i_s."""

    unit: str = "1/(N m)"
    limit: float = 0.3

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        g = column(np.maximum(gain, 1e-9), m)
        return np.asarray(np.arctanh(np.clip(g * m, -0.999, 0.999)) / g)

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        g = column(np.maximum(gain, 1e-9), i)
        return np.asarray(np.tanh(g * i) / g)


@dataclass(frozen=True)
class Ripple(Motor):
    """The constant varies with the rotor's angle: six times a pole pair, or another order."""

    w: float = 108.0
    phase: float = 0.0
    limit: float = 0.3

    def _constant(self, gain: Array, q: Array) -> Array:
        turn = self.w * q + self.phase
        return np.asarray(1 + column(gain, q) * (np.cos(turn) + 0.1 * np.cos(2 * turn)))

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        return np.asarray(m / self._constant(gain, q))

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        return np.asarray(i * self._constant(gain, q))


@dataclass(frozen=True)
class Gain(Motor):
    """The constant is not what the maker says."""

    sign: int = 1

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        return np.asarray(m / (1 + self.sign * column(gain, m)))

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        return np.asarray(i * (1 + self.sign * column(gain, i)))


@dataclass(frozen=True)
class Warming(Motor):
    """Copper losses warm the magnets: T' = (i^2 - T) / time, constant 1 - gain T."""

    unit: str = "1/(N m)2"
    limit: float = 0.1
    time: float = 30.0
    closed = False

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        step = float(t[0, 1] - t[0, 0]) / self.time
        i = m
        for _ in range(3):
            warm, start = [], np.zeros((6, 1))
            for run in range(m.shape[1]):  # one after the other, each as warm as the last left it
                T, start = lfilter([step], [1, step - 1], i[:, run] ** 2, axis=-1, zi=start)
                warm.append(T)
            i = m / (1 - column(gain, m) * np.stack(warm, axis=1))
        return np.asarray(i)


@dataclass(frozen=True)
class Teeth(Motor):
    """A gear of efficiency 1 - gain, driving or driven. After a reversal its teeth slip one after
    the other (Maxwell slip), the last of them after `width` [rad]."""

    limit: float = 0.3
    width: float = 2e-3
    closed = False

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        slip = self._slip(q)
        g, driving = column(gain, m), m * slip > 0
        return np.asarray(m + np.abs(m) * slip * np.where(driving, g / (1 - g), g))

    def _slip(self, q: Array) -> Array:
        """From -1 to 1: mean of eight stops that let go one after the other."""
        widths = self.width * np.arange(1, 9)[:, None, None] / 8
        stops, slip = np.zeros((8, *q.shape[:2])), np.zeros_like(q)
        for k, way in enumerate(np.moveaxis(np.diff(q, axis=-1), -1, 0), start=1):
            stops = np.maximum(np.minimum(stops + way / widths, 1), -1)
            slip[..., k] = stops.mean(axis=0)
        return slip


@dataclass(frozen=True)
class Crosstalk(Motor):
    """A motor feels part of its neighbour's current: m_i = i_i + gain_i i_(i+1)."""

    limit: float = 0.3

    def _mix(self, gain: Array) -> Array:
        return np.eye(6) + np.diag(gain) @ np.roll(np.eye(6), 1, axis=1)

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        return np.asarray(np.einsum("ij,j...->i...", np.linalg.inv(self._mix(gain)), m))

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        return np.asarray(np.einsum("ij,j...->i...", self._mix(gain), i))


@dataclass(frozen=True)
class Pickup(Motor):
    """50 Hz of the mains in the torque reading; no torque of the motor."""

    unit: str = "N m"
    phase: float = 0.0

    def _hum(self, gain: Array, t: Array, like: Array) -> Array:
        return np.asarray(column(gain, like) * np.sin(2 * np.pi * 50.02 * t + self.phase))

    def reported(self, gain: Array, m: Array, t: Array, q: Array) -> Array:
        return np.asarray(m + self._hum(gain, t, m))

    def real(self, gain: Array, i: Array, t: Array, q: Array) -> Array:
        return np.asarray(i - self._hum(gain, t, i))


@dataclass(frozen=True)
class Drive:
    """Between command and reported torque: kind is lag, delay [s] or limit [1/(N m)]."""

    kind: str
    unit: str = "s"
    limit: float = 0.02
    announced: dict[str, float] = field(default_factory=dict)
    everywhere = False

    @property
    def closed(self) -> bool:
        """The closed loop has no delay but its own."""
        return self.kind != "delay"

    def command(self, gain: Array, i: Array, t: Array) -> Array:
        """Command (6, runs, samples) behind a reported torque i; t (runs, samples)."""
        if self.kind == "limit":
            g = column(np.maximum(gain, 1e-9), i)
            return np.asarray(np.arctanh(np.clip(g * i, -0.99, 0.99)) / g)
        command, clock = i.copy(), t[0] - t[0, 0]
        for joint in np.flatnonzero(gain):
            curve = CubicSpline(clock, i[joint], axis=-1)
            if self.kind == "delay":
                command[joint] = curve(clock + gain[joint])
            else:
                command[joint] = i[joint] + gain[joint] * curve(clock, 1)
        return command


@dataclass(frozen=True)
class Encoder:
    """The grating is off centre: reading = q + gain (sin(q + phase) - sin(phase))."""

    unit: str = "rad"
    limit: float = 0.02
    announced: dict[str, float] = field(default_factory=dict)
    phase: Array = field(default_factory=lambda: np.zeros(6))
    closed = True
    everywhere = False

    def reading(self, gain: Array, q: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
        """Angle read, its rate and acceleration."""
        g, turn = column(gain, q), q + column(self.phase, q)
        s, c = np.sin(turn), np.cos(turn)
        start = np.sin(column(self.phase, q))
        return q + g * (s - start), v * (1 + g * c), a * (1 + g * c) - g * s * v * v


DRIVES: dict[str, Callable[[Rng], Motor | Drive | Encoder]] = {
    "torque_constant_saturation": lambda rng: Saturating(),
    "torque_ripple": lambda rng: Ripple(
        w=36.0 * float(rng.choice([0.5, 1.0, 2.0, 3.0])), phase=rng.uniform(0, 2 * np.pi)
    ),
    "drive_gain": lambda rng: Gain(sign=int(rng.choice([-1, 1]))),
    "thermal_drift": lambda rng: Warming(time=rng.uniform(15, 60)),
    "load_friction": lambda rng: Teeth(width=rng.uniform(1e-3, 4e-3)),
    "cross_coupling": lambda rng: Crosstalk(),
    "torque_saturation": lambda rng: Drive("limit", "1/(N m)", 0.3),
    "drive_lag": lambda rng: Drive("lag"),
    "time_delay": lambda rng: Drive("delay"),
    "encoder_eccentricity": lambda rng: Encoder(phase=rng.uniform(0, 2 * np.pi, 6)),
}
