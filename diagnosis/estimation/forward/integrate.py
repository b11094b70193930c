"""Forward dynamics of any base model, many windows at once.

    M(q) qdd = tau - h(q, qd) - what stands beside

Column j of M is tau(q, qd, e_j) - tau(q, qd, 0) and h is tau(q, qd, 0), so that torques at chosen
states are all that a base model must give. A step is the implicit midpoint rule in the rate, with
friction solved for, and explicit in what the mechanism itself does: of second order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.estimation.forward.beside import Part, Step
from flexhex.fmus.common.errors import MachineError

Array = NDArray[np.float64]
TURNS, SOLVED = 8, 1e-4
"""Iterations of a step at most, and the change of a rate, relative to the largest of the windows,
that ends them. With sixty, to 1e-10, the errors differ by 0.6 % at most (a measured arm, two links,
a cart)."""


@dataclass(frozen=True)
class Windows:
    """Measured windows of one step dt [s]: theta (windows, steps + 1, n), thetad (windows, n) at
    their start, tau (windows, steps, n) in the middle of each step, reported (windows, steps, n)
    the same before drives lose or delay any of it, time (windows,) [s] of the start since that of
    the run; widest (n,): how far an axis may be from where it was measured before its window has
    diverged."""

    theta: Array
    thetad: Array
    tau: Array
    reported: Array
    time: Array
    widest: Array
    dt: float


def mechanics(base: Base, p: Array, theta: Array, thetad: Array) -> tuple[Array, Array]:
    """M (windows, n, n) and h (windows, n) at these states (windows, n)."""
    count, n = theta.shape
    unit = np.concatenate([np.zeros((1, n)), np.eye(n)])
    q, v = np.tile(theta, (n + 1, 1)), np.tile(thetad, (n + 1, 1))
    torque = base.torque(Motion(0.0, 1.0, q, v, np.repeat(unit, count, axis=0)), p)
    torque = torque.reshape(n + 1, count, n)
    return np.moveaxis(torque[1:] - torque[0], 0, 2), torque[0]


def invertible(base: Base, p: Array, theta: Array) -> bool:
    """Whether masses at these angles (windows, n) give each torque an acceleration of its sign."""
    try:
        mass = mechanics(base, p, theta, np.zeros_like(theta))[0]
    except MachineError:
        return False
    return bool(np.linalg.eigvalsh((mass + np.swapaxes(mass, 1, 2)) / 2).min() > 0)


@np.errstate(all="ignore")
def simulated(
    base: Base, p: Array, parts: Sequence[Part], states: Sequence[Array], windows: Windows
) -> Array:
    """Angles (windows, steps + 1, n) from the measured torques; NaN where a window has diverged.

    states: what each of the parts has in memory at the start (windows, k).
    """
    told = np.full_like(windows.theta, np.nan)
    told[:, 0], dt = windows.theta[:, 0], windows.dt
    q, v = windows.theta[:, 0], windows.thetad
    last, alive = v, np.arange(len(q))
    for k in range(windows.tau.shape[1]):
        # the rate in the middle, on from the step before
        time, guess = windows.time[alive] + (k + 0.5) * dt, v + (v - last) / 2
        try:
            mass, h = mechanics(base, p, q + dt / 2 * v, guess)
            tau, drive = windows.reported[alive, k], windows.tau[alive, k] - h
            middle = _middle(parts, states, mass, tau, drive, (q, v), guess, time, dt)
        except (MachineError, np.linalg.LinAlgError):
            break
        then, fast = q + dt * middle, 2 * middle - v
        moved = [_step(part.axis, (q, v), (then, fast), tau, time + dt / 2, dt) for part in parts]
        states = [part.follow(m, s) for part, m, s in zip(parts, moved, states, strict=True)]
        off = np.abs(then - windows.theta[alive, k + 1])
        good = np.isfinite(fast).all(axis=1) & (off < windows.widest).all(axis=1)
        q, last, v = then[good], v[good], fast[good]
        alive, states = alive[good], [state[good] for state in states]
        if not len(alive):
            break
        told[alive, k + 1] = q
    return told


def _middle(
    parts: Sequence[Part],
    states: Sequence[Array],
    mass: Array,
    tau: Array,
    drive: Array,
    now: tuple[Array, Array],
    middle: Array,
    time: Array,
    dt: float,
) -> Array:
    """Rates (windows, n) in the middle of a step, where `drive` minus friction accelerates them;
    middle: a guess."""
    (q, v), mass, n = now, 2 / dt * mass, middle.shape[1]
    for _ in range(TURNS):
        torque, slope = np.zeros_like(v), np.zeros_like(v)
        for part, state in zip(parts, states, strict=True):
            there = q + dt / 2 * middle, middle
            own, steep = part.torque(_step(part.axis, now, there, tau, time, dt / 2), state)
            torque[:, part.axis] += own
            slope[:, part.axis] += steep
        left = drive - torque - (mass @ (middle - v)[:, :, None])[:, :, 0]
        change = np.linalg.solve(mass + slope[:, :, None] * np.eye(n), left[:, :, None])[:, :, 0]
        middle = middle + change
        if not parts or not np.abs(change).max() > SOLVED * np.abs(middle).max():
            break
    return middle


def _step(
    axis: int,
    now: tuple[Array, Array],
    then: tuple[Array, Array],
    tau: Array,
    time: Array,
    dt: float,
) -> Step:
    (q, v), (q_then, v_then) = now, then
    return Step(q[:, axis], v[:, axis], q_then[:, axis], v_then[:, axis], tau[:, axis], time, dt)
