"""What nature adds to the machine, by identifier: torques at the joints.

The forms are those of mechanics, not of a regression: bristles (LuGre) for friction, Bouc-Wen
for hysteresis, a sprung inertia for a flexible mode; `torques.py` says what a torque is. Effects
in motor, drive and encoder are in `drives.py`, those outside any list in `outside.py`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from studies.generator.torques import Algebraic, BoucWen, Bristles, Sprung, Tilt, Torque
from tests.oracles.calculus import Array

Rng = np.random.Generator


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
        announced={"power": power},
        form=lambda t, q, v: np.sign(v) * np.abs(v) ** power,
    )


def cogging(rng: Rng) -> Torque:
    """Slot passing at an order that is not modelled, with a weak overtone."""
    order = rng.choice([10.0, 11.0, 12.0, 1.5, 2.5, 3.5, 5.3, 7.4, 10.6])
    w, phase = 36.0 * order, _phases(rng)

    def form(t: Array, q: Array, v: Array) -> Array:
        turn = w * q + column(phase, q)
        return np.asarray(np.cos(turn) + 0.1 * np.cos(2 * turn + 1))

    return Algebraic(announced={"order": float(order)}, form=form)


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
        announced={"angle": float(side * edge), "soft": soft},
        form=lambda t, q, v: side * soft * np.logaddexp(0, (side * q - edge) / soft),
    )


def offset_drift(rng: Rng) -> Torque:
    """An offset that creeps in with time."""
    time, sign = rng.uniform(15, 60), rng.choice([-1, 1], 6)
    return Algebraic(
        announced={"time": time},
        form=lambda t, q, v: column(sign, q) * (1 - np.exp(-np.maximum(t, 0) / time)) + 0 * q,
    )


def flexible(rng: Rng) -> Torque:
    """A mode of 10 to 22 Hz."""
    hertz, zeta = rng.uniform(10, 22), rng.uniform(0.02, 0.06)
    return Sprung(w=2 * np.pi * hertz, zeta=zeta, announced={"frequency": hertz, "damping": zeta})


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
