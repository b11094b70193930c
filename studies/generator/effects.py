"""What nature adds to the machine, by identifier: torques at the joints.

The forms are those of mechanics, not of a regression: bristles (LuGre) for friction, Bouc-Wen
for hysteresis, a sprung inertia for a flexible mode. Every effect here is written for unit gain:

    torque = gain (6,) * (force(t, q, v, z) + inertia(q) * a),   dz/dt = rate(t, q, v, a, z)

with t [s] since the machine was switched on, q, v, a (6, ...) [rad, rad/s, rad/s2], z (states,
6, ...). Effects in motor, drive and encoder are in `drives.py`, those outside any list in
`outside.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from studies.generator.mechanism import Linear, Mechanism
from tests.oracles.calculus import Array

Rng = np.random.Generator


@dataclass(frozen=True)
class Torque:
    """An effect that is a torque at the joint; `unit` is that of its gain, `limit` its bound."""

    unit: str = "N m"
    limit: float = np.inf
    states: int = 0
    told: dict[str, float] = field(default_factory=dict)
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


def column(values: Array, q: Array) -> Array:
    """Values of the joints (6, ...), with as many axes as q (6, ...)."""
    return values.reshape(*values.shape, *[1] * (q.ndim - values.ndim))


def _phases(rng: Rng) -> Array:
    return rng.uniform(0, 2 * np.pi, 6)


def coulomb(rng: Rng) -> Torque:
    """Dry friction."""
    return Bristles(width=rng.uniform(1e-3, 3e-3), rise=rng.uniform(1.0, 1.1))


def stribeck(rng: Rng) -> Torque:
    """Dry friction that falls as the joint starts to slide."""
    rise, rate = rng.uniform(1.7, 2.5), rng.uniform(0.05, 0.25)
    return Bristles(width=rng.uniform(1e-3, 3e-3), rise=rise, stribeck=rate)


def drag(rng: Rng) -> Torque:
    """Turbulent drag; its exponent is only about two."""
    power = rng.uniform(1.9, 2.1)
    return Algebraic(
        "N m s2/rad2",
        told={"power": power},
        form=lambda t, q, v: np.sign(v) * np.abs(v) ** power,
    )


def cogging(rng: Rng) -> Torque:
    """Slot passing at an order that is not modelled, with a weak overtone."""
    order = rng.choice([10.0, 11.0, 12.0, 1.5, 2.5, 3.5, 5.3, 7.4, 10.6])
    w, phase = 36.0 * order, _phases(rng)

    def form(t: Array, q: Array, v: Array) -> Array:
        turn = w * q + column(phase, q)
        return np.asarray(np.cos(turn) + 0.1 * np.cos(2 * turn + 1))

    return Algebraic(told={"order": float(order)}, form=form)


def hysteresis(rng: Rng) -> Torque:
    """Hysteresis far narrower or wider than the one modelled."""
    width = rng.uniform(0.002, 0.004) if rng.random() < 0.5 else rng.uniform(0.05, 0.09)
    return BoucWen(width=width, n=rng.uniform(1.1, 1.6), beta=rng.uniform(0.6, 0.9))


def quadratic(rng: Rng) -> Torque:
    """A flexure preloaded to one side: 2 (1 - cos q), about q^2."""
    sign = rng.choice([-1, 1])
    return Algebraic("N m/rad2", form=lambda t, q, v: sign * 2 * (1 - np.cos(q)))


def cubic(rng: Rng) -> Torque:
    """A stiffening flexure: 3 (tan q - q), about q^3."""
    return Algebraic("N m/rad3", form=lambda t, q, v: 3 * (np.tan(q) - q))


def cable(rng: Rng) -> Torque:
    """A cable that comes taut over some mrad beyond an angle, to one side."""
    side, edge, soft = rng.choice([-1, 1]), rng.uniform(0.0, 0.08), rng.uniform(1e-3, 4e-3)
    return Algebraic(
        "N m/rad",
        told={"angle": float(side * edge), "soft": soft},
        form=lambda t, q, v: side * soft * np.logaddexp(0, (side * q - edge) / soft),
    )


def offset_drift(rng: Rng) -> Torque:
    """An offset that creeps in with time."""
    time, sign = rng.uniform(15, 60), rng.choice([-1, 1], 6)
    return Algebraic(
        told={"time": time},
        form=lambda t, q, v: column(sign, q) * (1 - np.exp(-np.maximum(t, 0) / time)) + 0 * q,
    )


def flexible(rng: Rng) -> Torque:
    """A mode of 10 to 22 Hz."""
    hertz, zeta = rng.uniform(10, 22), rng.uniform(0.02, 0.06)
    return Sprung(w=2 * np.pi * hertz, zeta=zeta, told={"frequency": hertz, "damping": zeta})


TORQUES: dict[str, Callable[[Rng], Torque]] = {
    "coulomb_friction": coulomb,
    "stribeck_friction": stribeck,
    "quadratic_drag": drag,
    "cogging_harmonic": cogging,
    "second_hysteresis": hysteresis,
    "quadratic_stiffness": quadratic,
    "cubic_stiffness": cubic,
    "cable_force": cable,
    "offset_drift": offset_drift,
    "flexible_mode": flexible,
    "gravity_tilt": lambda rng: Tilt(heading=rng.uniform(0, 2 * np.pi)),
}


def follow(effect: Torque, t: Array, q: Array, v: Array, a: Array) -> Array:
    """States (states, 6, runs, samples) along q, v, a (6, runs, samples), by Runge-Kutta.

    t (runs, samples) [s]. Between samples the path is the cubic through angles and rates.
    """
    z = np.zeros((effect.states, *q.shape))
    step = float(t[0, 1] - t[0, 0])
    for k in range(q.shape[-1] - 1):
        one, two = (x[..., k] for x in (q, v, a)), (x[..., k + 1] for x in (q, v, a))
        (q0, v0, a0), (q1, v1, a1) = one, two
        qm, vm = (q0 + q1) / 2 + step / 8 * (v0 - v1), (v0 + v1) / 2 + step / 8 * (a0 - a1)
        am, tm, now = (a0 + a1) / 2, t[:, k] + step / 2, z[..., k]
        k1 = effect.rate(t[:, k], q0, v0, a0, now)
        k2 = effect.rate(tm, qm, vm, am, now + step / 2 * k1)
        k3 = effect.rate(tm, qm, vm, am, now + step / 2 * k2)
        k4 = effect.rate(t[:, k + 1], q1, v1, a1, now + step * k3)
        z[..., k + 1] = now + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return z


def shape(effect: Torque, t: Array, q: Array, v: Array, a: Array) -> Array:
    """Torque (6, runs, samples) of the effect for unit gain along given motions."""
    z = follow(effect, t, q, v, a) if effect.states else np.zeros((0, *q.shape))
    return np.asarray(effect.force(t, q, v, z) + effect.inertia(q) * a)
