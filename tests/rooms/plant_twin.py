"""The plant's step in NumPy, and motions of the plant.

The twin integrates with the CasADi functions of the room, which tests/oracles holds against
Lagrange's equations; the current loop and everything around it are its own.
"""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from flexhex.fmus.plant.equations import functions
from tests.rooms.loaded import Array, Loaded, machine

TS = 0.00025
EXACT = {"theta_step": 0.0, "tau_step": 0.0}
"""Sensors and drives without quanta."""
HOLD = np.array([2.1, 2.4, 1.9, 2.2, 2.0, 2.3])
"""Torque (6,) [N m] that moves the machine gently from its neutral pose."""


@cache
def equations() -> dict[str, ca.Function]:
    return {f.name(): f for f in functions(machine())}


def values(result: ca.DM) -> Array:
    return np.array(result).ravel()


def motion(room: Loaded) -> tuple[Array, Array, Array]:
    """theta, thetad (6,), d (31,) unquantised, from the state."""
    return room.state[:6].copy(), room.state[6:12].copy(), room.state[12:43].copy()


def torques(ticks: int, seed: int) -> Array:
    """Commands (ticks, 6) [N m] that wander about what holds the machine."""
    rng, t = np.random.default_rng(seed), TS * np.arange(ticks)[:, None]
    phase, f = rng.uniform(0, 6, 6), rng.uniform(1, 4, 6)
    return HOLD + 1.5 * np.sin(2 * np.pi * f * t + phase)


class Twin:
    """The plant's step in NumPy, without quanta, delays and stops."""

    def __init__(self, room: Loaded, substeps: int) -> None:
        self.p, self.h = room.p, TS / substeps
        self.substeps = substeps
        d = values(equations()["plant_neutral"]()["d"])
        self.y, self.tau = np.concatenate([np.zeros(12), d, np.zeros(6)]), np.zeros(6)

    def slope(self, y: Array, tau: Array, payload: float) -> Array:
        theta, thetad, d, z = np.split(y, [6, 12, 43])
        fixed = (self.p["mechanism"], self.p["actuator"], payload)
        rates = equations()["plant_rates"](theta, thetad, d, z, tau, *fixed)
        return np.concatenate([thetad, *(values(rate) for rate in rates)])

    def tick(self, command: Array, payload: float) -> None:
        limited = np.clip(command, -self.p["tau_max"], self.p["tau_max"])
        for _ in range(self.substeps):
            self.substep(limited, payload)

    def substep(self, command: Array, payload: float) -> None:
        """Runge-Kutta with the torque at start, middle and end; the middle keeps the impulse."""
        reach, h = 2 * np.pi * self.p["f_current"] * self.h, self.h
        first, last = self.tau, command + (self.tau - command) * np.exp(-reach)
        impulse = command + (self.tau - command) * (1 - np.exp(-reach)) / reach
        middle = (6 * impulse - first - last) / 4
        k1 = self.slope(self.y, first, payload)
        k2 = self.slope(self.y + h / 2 * k1, middle, payload)
        k3 = self.slope(self.y + h / 2 * k2, middle, payload)
        k4 = self.slope(self.y + h * k3, last, payload)
        self.y, self.tau = self.y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), last
        closed = equations()["plant_close"](self.y[:6], self.y[12:43])[0]
        self.y[12:43] = values(closed)
