"""Effects that no list names: torques that a verdict should call unknown, or not see at all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from studies.generator.drives import Motor, Pickup
from studies.generator.effects import Rng, column
from studies.generator.torques import Algebraic, Sprung, Torque
from tests.oracles.calculus import Array


@dataclass(frozen=True)
class UnevenInertia(Torque):
    """Inertia that varies with the angle: J a + J' v^2 / 2 with J = sin(w q + phase)."""

    unit: str = "kg m2"
    limit: float = 0.03
    w: float = 6.0
    phase: float = 0.0

    def inertia(self, q: Array) -> Array:
        return np.asarray(np.sin(self.w * q + self.phase))

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return np.asarray(self.w * np.cos(self.w * q + self.phase) * v * v / 2)


@dataclass(frozen=True)
class Sticking(Torque):
    """Catches at certain angles, every time by another amount and often not at all."""

    spacing: float = 0.05
    phase: float = 0.0
    decay: float = 0.03
    seed: int = 0
    closed = False

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        cell = np.floor((q - self.phase) / self.spacing)
        crossed = np.diff(cell, axis=-1, prepend=cell[..., :1])
        rng = np.random.default_rng(self.seed)
        kick = np.sign(crossed) * rng.exponential(1.0, q.shape) * (rng.random(q.shape) < 0.6)
        pole = np.exp(-float(t[0, 1] - t[0, 0]) / self.decay)
        return np.asarray(lfilter([1.0], [1.0, -pole], kick, axis=-1))


@dataclass(frozen=True)
class Memory(Torque):
    """Damping with memory: a spring in series with a dashpot that yields the more it is loaded."""

    unit: str = "N m/rad"
    states: int = 1
    time: float = 0.1
    yielding: float = 0.02

    def rate(self, t: Array, q: Array, v: Array, a: Array, z: Array) -> Array:
        return np.asarray(v - z / self.time * (1 + np.abs(z) / self.yielding))

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return np.asarray(z[0] * (1 + (z[0] / 0.05) ** 2))


def backlash(rng: Rng) -> Torque:
    """A part of the arm rattles in a gap of some mrad."""
    hertz, play = rng.uniform(18, 30), rng.uniform(1e-3, 4e-3)
    announced = {"frequency": hertz, "play": play}
    return Sprung(w=2 * np.pi * hertz, zeta=rng.uniform(0.1, 0.3), play=play, announced=announced)


def bump(rng: Rng) -> Torque:
    """A dent: the torque rises at one angle only."""
    place, width = rng.uniform(-0.08, 0.08), rng.uniform(0.008, 0.025)
    return Algebraic(
        announced={"angle": place, "width": width},
        form=lambda t, q, v: np.exp(-(((q - place) / width) ** 2)),
    )


def creep(rng: Rng) -> Torque:
    """Stiffness that falls as the flexures warm up."""
    time = rng.uniform(20, 80)
    return Algebraic(
        "N m/rad",
        announced={"time": time},
        form=lambda t, q, v: -q * (1 - np.exp(-np.maximum(t, 0) / time)),
    )


def limit_cycle(rng: Rng) -> Torque:
    """The loop hunts between two encoder steps while a joint stands still."""
    w, phase = 2 * np.pi * rng.uniform(9, 17), rng.uniform(0, 2 * np.pi, 6)

    def form(t: Array, q: Array, v: Array) -> Array:
        swing = np.tanh(4 * np.sin(w * t + column(phase, q)))
        return np.asarray(swing * np.exp(-((v / 0.05) ** 2)))

    return Algebraic(form=form)


OUTSIDE: dict[str, Callable[[Rng], Torque | Motor]] = {
    "backlash": backlash,
    "uneven_inertia": lambda rng: UnevenInertia(
        w=rng.uniform(8, 16), phase=rng.uniform(0, 2 * np.pi)
    ),
    "sticking": lambda rng: Sticking(
        spacing=rng.uniform(0.03, 0.09), phase=rng.uniform(0, 0.03), seed=int(rng.integers(2**31))
    ),
    "stiffness_creep": creep,
    "limit_cycle": limit_cycle,
    "torque_bump": bump,
    "memory_damping": lambda rng: Memory(
        time=rng.uniform(0.05, 0.2), yielding=rng.uniform(0.01, 0.04)
    ),
    "mains_pickup": lambda rng: Pickup(phase=rng.uniform(0, 2 * np.pi)),
}
