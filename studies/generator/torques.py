"""Kinds of torque at a joint: functions of the motion, bristles, hysteresis, springs, a tilt.

Every effect here is written for unit gain:

    torque = gain (6,) * (force(t, q, v, z) + inertia(q) * a),   dz/dt = rate(t, q, v, a, z)

with t [s] since the machine was switched on, q, v, a (6, ...) [rad, rad/s, rad/s2], z (states,
6, ...).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from studies.generator.masses import Linear
from studies.generator.mechanism import Mechanism
from tests.oracles.calculus import Array


@dataclass(frozen=True)
class Torque:
    """An effect that is a torque at the joint; `unit` is that of its gain, `limit` its bound."""

    unit: str = "N m"
    limit: float = np.inf
    states: int = 0
    announced: dict[str, float] = field(default_factory=dict)
    everywhere = False
    closed = True

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        """Part of the torque that needs no acceleration, for unit gain."""
        raise NotImplementedError

    def inertia(self, q: Array) -> Array | float:
        """Part of the torque per acceleration, for unit gain."""
        return 0.0

    def rate(self, t: Array, q: Array, v: Array, a: Array, z: Array) -> Array:
        """Derivative of the states; they start at zero."""
        return z


Form = Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class Algebraic(Torque):
    """A torque that is a function of time, angle and rate."""

    form: Form = lambda t, q, v: q

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return self.form(t, q, v)


@dataclass(frozen=True)
class Bristles(Torque):
    """LuGre friction: a bristle of `width` [rad] bends and slips; `rise` is static over sliding
    friction, `stribeck` [rad/s] the rate at which it falls off."""

    states: int = 1
    width: float = 2e-3
    rise: float = 1.0
    stribeck: float = 0.1

    def rate(self, t: Array, q: Array, v: Array, a: Array, z: Array) -> Array:
        level = 1 + (self.rise - 1) * np.exp(-((v / self.stribeck) ** 2))
        return np.asarray((v - np.abs(v) * z / level) / self.width)

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return np.asarray(z[0] + 0.02 * self.rate(t, q, v, v, z)[0] * self.width)


@dataclass(frozen=True)
class BoucWen(Torque):
    """Hysteresis of `width` [rad] whose loops are not those of Dahl: sharpness n, shape beta."""

    states: int = 1
    width: float = 0.05
    n: float = 1.5
    beta: float = 0.7

    def rate(self, t: Array, q: Array, v: Array, a: Array, z: Array) -> Array:
        size = np.abs(z) ** self.n
        lost = self.beta * np.abs(v) * np.sign(z) * size + (1 - self.beta) * v * size
        return np.asarray((v - lost) / self.width)

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return np.asarray(z[0])


@dataclass(frozen=True)
class Sprung(Torque):
    """Two masses: part of the arm's inertia hangs on a spring, its angle against the arm is z.

    z" = -a - 2 zeta w z' - w^2 free(z); on the arm acts J z" beyond the rigid inertia. With
    `play` [rad] the spring has a gap: backlash.
    """

    unit: str = "kg m2"
    limit: float = 0.035
    states: int = 2
    w: float = 100.0
    zeta: float = 0.02
    play: float = 0.0

    def _pull(self, z: Array) -> Array:
        x, xd = z
        touching = np.abs(x) >= self.play
        spring = np.sign(x) * np.maximum(np.abs(x) - self.play, 0)
        return np.asarray(-(self.w**2) * spring - 2 * self.zeta * self.w * xd * touching)

    def rate(self, t: Array, q: Array, v: Array, a: Array, z: Array) -> Array:
        return np.stack([z[1], self._pull(z) - a])

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        return self._pull(z)

    def inertia(self, q: Array) -> Array | float:
        return -1.0


@dataclass(frozen=True)
class Tilt(Torque):
    """The base leans: gravity turned by a small angle about a level line, in all joints."""

    unit: str = "rad"
    limit: float = 0.2
    heading: float = 0.0
    mechanism: Mechanism | None = None
    masses: Linear | None = None
    everywhere = True
    closed = False

    def force(self, t: Array, q: Array, v: Array, z: Array) -> Array:
        assert self.mechanism is not None
        assert self.masses is not None
        size = np.linalg.norm(self.mechanism.g)
        side = size * np.array([np.cos(self.heading), np.sin(self.heading), 0.0])
        flat, still = q.reshape(6, -1), np.zeros((6, q[0].size))
        light = Linear(*(*list(vars(self.masses).values())[:4], np.zeros(2), np.zeros(2)))
        return self.mechanism.inverse(flat, still, still, light, side).reshape(q.shape)
