"""The plant's step in NumPy, and motions of the plant.

The twin integrates with the CasADi functions of the block, which tests/oracles holds against
Lagrange's equations; the current loop and everything around it are its own.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from flexhex.fmus.plant.equations import functions
from tests.blocks.loaded import Array, Loaded, load, machine

TS = 0.00025
EXACT = {"theta_step": 0.0, "tau_step": 0.0}
"""Sensors and drives without quanta."""
HOLD = np.array([2.1, 2.4, 1.9, 2.2, 2.0, 2.3])
"""Torque (6,) [N m] that moves the machine gently from its neutral pose."""


def started(**parameters: object) -> Loaded:
    block = load("plant")
    block.start(**parameters)
    return block


@cache
def equations() -> dict[str, ca.Function]:
    return {f.name(): f for f in functions(machine())}


def values(result: ca.DM) -> Array:
    return np.array(result).ravel()


def motion(block: Loaded) -> tuple[Array, Array, Array]:
    """theta, thetad (6,), d (31,) unquantised, from the state."""
    return block.state[:6].copy(), block.state[6:12].copy(), block.state[12:43].copy()


def torques(ticks: int, seed: int) -> Array:
    """Commands (ticks, 6) [N m] that wander about what holds the machine."""
    rng, t = np.random.default_rng(seed), TS * np.arange(ticks)[:, None]
    phase, f = rng.uniform(0, 6, 6), rng.uniform(1, 4, 6)
    return HOLD + 1.5 * np.sin(2 * np.pi * f * t + phase)


class Drives:
    """Torque of first-order current loops over a substep, t from 0 to 1."""

    def __init__(self, tau: Array, command: Array, reach: float) -> None:
        self.tau, self.command, self.reach = tau, command, reach

    def at(self, t: Any) -> Array:
        return np.asarray(self.command + (self.tau - self.command) * np.exp(-self.reach * t))

    @property
    def middle(self) -> Array:
        """For which Simpson's rule gives the impulse."""
        first, last, gap = self.at(0), self.at(1), self.tau - self.command
        impulse = self.command + gap * -np.expm1(-self.reach) / self.reach
        return (6 * impulse - first - last) / 4

    def integral(self, slopes: list[Array], nodes: list[float], late: bool = False) -> Array:
        """Of response (tau, 1) over a substep; late: of (1 - t) times that.

        The response goes through `slopes` (6, 7) at `nodes`; Gauss-Legendre on four pieces.
        """
        points, weights = np.polynomial.legendre.leggauss(24)
        t = np.concatenate([(piece + (points + 1) / 2) / 4 for piece in range(4)])
        weight = np.tile(weights / 8, 4) * (1 - t if late else 1)
        torque = np.vstack([self.at(t[:, None]).T, np.ones_like(t)])
        total = np.zeros(6)
        for slope, a in zip(slopes, nodes, strict=True):
            shares = np.prod([(t - b) / (a - b) for b in nodes if b != a], axis=0)
            total += slope @ (torque * shares @ weight)
        return total


class RungeKutta:
    """The plant by the classical Runge-Kutta method, without quanta, delays and stops."""

    def __init__(self, block: Loaded, substeps: int) -> None:
        self.p, self.h = block.p, TS / substeps
        self.substeps = substeps
        d = values(equations()["plant_neutral"]()["d"])
        self.y, self.tau = np.concatenate([np.zeros(12), d, np.zeros(6)]), np.zeros(6)

    def evaluated(self, y: Array, payload: float) -> tuple[Array, Array, Array]:
        """response (6, 7), dd, zd."""
        theta, thetad, d, z = np.split(y, [6, 12, 43])
        fixed = (self.p["mechanism"], self.p["actuator"], payload)
        response, dd, zd = equations()["plant_rates"](theta, thetad, d, z, *fixed)
        return np.array(response), values(dd), values(zd)

    def slope(self, y: Array, tau: Array, payload: float) -> Array:
        response, dd, zd = self.evaluated(y, payload)
        return np.concatenate([y[6:12], response @ np.append(tau, 1.0), dd, zd])

    def tick(self, command: Array, payload: float) -> None:
        limited = np.clip(command, -self.p["tau_max"], self.p["tau_max"])
        for _ in range(self.substeps):
            drives = Drives(self.tau, limited, 2 * np.pi * self.p["f_current"] * self.h)
            self.substep(drives, payload)
            self.tau = drives.at(1)

    def substep(self, drives: Drives, payload: float) -> None:
        """The torque's middle keeps the impulse; theta gets what the impulse does till the end."""
        h, y = self.h, self.y
        first, middle, last = drives.at(0), drives.middle, drives.at(1)
        k1 = self.slope(y, first, payload)
        k2 = self.slope(y + h / 2 * k1, middle, payload)
        k3 = self.slope(y + h / 2 * k2, middle, payload)
        k4 = self.slope(y + h * k3, last, payload)
        response = self.evaluated(y, payload)[0]
        response[:, 6] = 0.0
        late = drives.integral([response], [0.0], late=True)
        late -= response[:, :6] @ (first + 2 * middle) / 6
        self.y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        self.y[:6] += h**2 * late
        self.y[43:] = self.hysteresis(y)
        self.close()

    def close(self) -> None:
        self.y[12:43] = values(equations()["plant_close"](self.y[:6], self.y[12:43])[0])

    def hysteresis(self, before: Array) -> Array:
        """z where the angles have got to; each joint turns once at most."""
        delta = self.y[:6] - before[:6]
        until = self.until_turn(self.h * before[6:12], self.h * self.y[6:12], delta)
        return self.dahl(self.dahl(before[43:], until), delta - until)

    def dahl(self, z: Array, delta: Array) -> Array:
        """[SH, Eq. (23)] in closed form."""
        s = np.sign(delta)
        return np.asarray(s + (z - s) * np.exp(-np.abs(delta) / machine().actuator.sigma))

    def until_turn(self, first: Array, last: Array, whole: Array) -> Array:
        """How far each joint goes before it turns: the rate is quadratic."""
        reached = whole.copy()
        for i in np.flatnonzero(first * last < 0):
            # the integral is a cubic through 0 with these slopes at its ends
            travel = np.polynomial.Polynomial(
                [
                    0.0,
                    first[i],
                    3 * whole[i] - 2 * first[i] - last[i],
                    first[i] + last[i] - 2 * whole[i],
                ]
            )
            turns = travel.deriv().roots()
            (turn,) = [t.real for t in turns if abs(t.imag) < 1e-12 and 0 <= t.real <= 1]
            reached[i] = travel(turn)
        return reached


class Twin(RungeKutta):
    """The plant's step: one evaluation where the last four substeps had the same payload."""

    def __init__(self, block: Loaded, substeps: int) -> None:
        super().__init__(block, substeps)
        self.past: list[tuple[Array, Array, Array]] = []
        self.payload, self.ahead = 0.0, False

    def substep(self, drives: Drives, payload: float) -> None:
        if payload != self.payload:
            self.past, self.payload, self.ahead = [], payload, False
        if not self.ahead:
            self.past = [self.evaluated(self.y, payload), *self.past]
        self.ahead = len(self.past) >= 5
        if not self.ahead:
            super().substep(drives, payload)
            return
        h, y = self.h, self.y
        slopes, ends = [slope[0] for slope in self.past[:5]], [0.0, -1.0, -2.0, -3.0, -4.0]
        theta = y[:6] + h * y[6:12] + h**2 * drives.integral(slopes, ends, late=True)
        nearly = y[6:12] + h * drives.integral(slopes, ends)
        rates = [slope[1] for slope in self.past[:5]]
        d = y[12:43] + h / 720 * np.array([1901.0, -2774.0, 2616.0, -1274.0, 251.0]) @ rates
        self.y = np.concatenate([theta, nearly, d, y[43:]])
        self.y[43:] = self.hysteresis(y)
        self.close()
        self.past = [self.evaluated(self.y, payload), *self.past[:4]]
        slopes, ends = [slope[0] for slope in self.past], [1.0, 0.0, -1.0, -2.0, -3.0]
        self.y[6:12] = y[6:12] + h * drives.integral(slopes, ends)
