"""E + K against the textbook's and Joseph's forms of the same update with BLAS."""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi as ca
import numpy as np

from benchmarks.blocks import Array, block
from benchmarks.clock import Rival, Row, Timing, measure
from benchmarks.motion import estimator_rows
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.fmus.estimator.interface import normalisation, process_noise

Update = Callable[..., tuple[Array, Array]]


def textbook(P: Array, q: Array, H: Array, y: Array, R1: Array, R2: float) -> tuple[Array, Array]:
    """P, q after one update, P <- (I - K H) P.  [SH, Eq. (34)-(37)]"""
    P = P + np.diag(R1)
    PH = P @ H.T
    K = np.linalg.solve(H @ PH + R2 * np.eye(len(H)), PH.T).T
    return (np.eye(len(P)) - K @ H) @ P, q + K @ (y - H @ q)


def joseph(P: Array, q: Array, H: Array, y: Array, R1: Array, R2: float) -> tuple[Array, Array]:
    """The same with P <- (I - K H) P (I - K H)^T + K R2 K^T, which stays symmetric."""
    P = P + np.diag(R1)
    PH = P @ H.T
    K = np.linalg.solve(H @ PH + R2 * np.eye(len(H)), PH.T).T
    left = np.eye(len(P)) - K @ H
    return left @ P @ left.T + R2 * (K @ K.T), q + K @ (y - H @ q)


def normalised_rows(machine: Machine, rows: Array) -> tuple[Array, Array]:
    """H (rows, n, n_p) and torque (rows, n) for rows of the estimator's inputs."""
    model, n = Model(machine), machine.n_arms
    x, xd, xdd = (ca.SX.sym(name, model.n_x) for name in ("x", "xd", "xdd"))
    chi = ca.SX.sym("chi", n * model.n_basis)
    regressor = ca.Function(
        "Phi", [x, xd, xdd, chi], [ca.densify(model.regressor(x, xd, xdd, chi))]
    )
    scale = normalisation(machine, base_parameters(machine))
    cuts = np.cumsum([model.n_x, model.n_x, model.n_x, n * model.n_basis])
    H = np.array([np.array(regressor(*np.split(row, cuts)[:4])) * scale for row in rows])
    return H, rows[:, cuts[3] :]


def rival(
    machine: Machine, H: Array, y: Array, update: Callable[..., tuple[Array, Array]]
) -> Rival:
    """NumPy's time for one update; P and q go on from update to update."""
    scale, R1 = normalisation(machine, base_parameters(machine)), process_noise(machine)
    R2, P0 = machine.control.R2, machine.control.P0
    state = [P0 * np.eye(len(R1)), base_parameters(machine) / scale]

    def run(count: int) -> float:
        begin = time.thread_time_ns()
        for k in range(count):
            state[:] = update(*state, H[k % len(H)], y[k % len(H)], R1, R2)
        return (time.thread_time_ns() - begin) / count

    return Rival(f"{update.__name__} (NumPy, BLAS)", run, "K alone, Phi given")


def kalman_row(machine: Machine, rounds: int) -> Row:
    """One tick of the estimator, regressor and filter."""
    rows = estimator_rows(machine)
    K = block("estimator", machine, rows, t_start=0.0)
    H, y = normalised_rows(machine, rows)
    rivals = [Rival("E + K", K.ticks), *(rival(machine, H, y, u) for u in (textbook, joseph))]
    timings = [*measure(rivals, rounds), Timing("paper", 11e6, 11e6, "its own computer")]
    what = f"E + K, {len(base_parameters(machine))} parameters"
    return Row("kalman", what, timings, 80e3, 45e3)
