"""One smooth periodic motion for all benchmarks, and what the blocks see of it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from benchmarks.blocks import Array, Instance, block
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import base_parameters

ROWS = 2000


def motion(Ts: float, rows: int = ROWS, n: int = 6) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (rows, n): sums of harmonics of the period rows Ts, so that the
    last sample leads to the first; 0.11 rad, 1.4 rad/s, 15 rad/s2 at a period of 1 s."""
    t = np.arange(rows)[:, None] * Ts
    base = 2 * np.pi / (rows * Ts)
    theta, thetad, thetadd = np.zeros((3, rows, n))
    for k, size in ((1, 0.08), (2, 0.04), (3, 0.02)):
        phase = np.arange(n) * (1.0 + 0.7 * k)
        w = k * base
        theta += size * np.sin(w * t + phase)
        thetad += size * w * np.cos(w * t + phase)
        thetadd -= size * w**2 * np.sin(w * t + phase)
    return theta, thetad, thetadd


def kinematics(machine: Machine) -> Instance:
    """N along the motion."""
    return block("kinematics", machine, np.hstack(motion(machine.timing.feedforward)))


def poses(machine: Machine, rows: int, every: int = 1) -> Array:
    """x, xd, xdd, z (rows, 117) as N publishes them, every so many ticks."""
    N = kinematics(machine)
    N.ticks(ROWS)
    listed = []
    for _ in range(rows):
        N.ticks(every)
        listed.append(np.concatenate([N.output(name) for name in ("x", "xd", "xdd", "z")]))
    return np.array(listed)


def feedforward_rows(machine: Machine, seen: Array) -> Array:
    """Inputs of F: poses and p."""
    p = base_parameters(machine)
    return np.hstack([seen, np.tile(p, (len(seen), 1))])


def torques(machine: Machine, seen: Array) -> Array:
    """tau (rows, 6) [N m] of the poses, by F."""
    F = block("feedforward", machine, feedforward_rows(machine, seen))
    listed = []
    for _ in seen:
        F.ticks(1)
        listed.append(F.output("tau_ff"))
    return np.array(listed)


def estimator_rows(machine: Machine, rows: int = 100) -> Array:
    """Inputs of E and K: x, xd, xdd, chi_f, tau_f at the rate of the estimator."""
    every = round(machine.timing.adaptation / machine.timing.feedforward)
    seen, model = poses(machine, rows, every), Model(machine)
    theta, z = ca.SX.sym("theta", model.n), ca.SX.sym("z", model.n)
    basis = ca.Function("basis", [theta, z], [model.basis(theta, z)])
    chi = np.array([np.array(basis(row[:6], row[-6:])).ravel() for row in seen])
    return np.hstack([seen[:, :-6], chi, torques(machine, seen)])
