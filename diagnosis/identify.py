"""Least-squares estimate of the 162 parameters from logs: the paper's "predetermined" p-hat.

    Phi p = tau for all samples of all logs                    [SH, Eq. (25), V-A case 2]

Columns and torque pass the same Hann window; every tenth of the smoothed samples is used, and
the normalised columns are solved by orthogonal factorisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.logs import Log
from diagnosis.motion import Columns, MotionModel, dahl_states, differences, hann, smooth
from fmus.common.errors import LogError
from fmus.common.machine import Machine
from fmus.common.parameters import parameters

Array = NDArray[np.float64]
EVERY = 10
"""Samples of the smoothed signals between two rows of the fit: 5 ms of a 50 ms window."""


@dataclass(frozen=True)
class Fit:
    """p (n_p,) with standard deviations, and how well it explains the logs.

    residual_rms (n,) [N m] for each joint after smoothing; condition: of the normalised
    columns; samples: number of torque values used; undetermined: names of parameters
    whose standard deviation exceeds their scale.
    """

    p: Array
    std: Array
    residual_rms: Array
    condition: float
    samples: int
    undetermined: tuple[str, ...]


def regression(model: MotionModel, log: Log, settle: float) -> tuple[Columns, Array]:
    """Smoothed columns and torque (samples, n) of one log, its first `settle` s left out."""
    machine = model.machine
    _check(machine, log)
    stride = max(1, round(machine.timing.feedforward / log.ts))
    theta, tau = log.theta[::stride], log.tau[::stride]
    ts, window = stride * log.ts, hann(machine.control.hann_points)
    first = int(settle / ts)
    if len(theta) < first + 4 * len(window):
        raise LogError(
            f"{log.name}: {log.theta.shape[0] * log.ts:.3g} s are too short, at least"
            f" {settle + 4 * len(window) * ts:.3g} s are needed"
        )
    z = dahl_states(theta, machine.actuator.sigma)
    thetad, thetadd = differences(theta, ts)
    cut = slice(max(first, 1), -1)
    raw = model.columns(
        theta[cut], z[cut], thetad[max(first - 1, 0) :], thetadd[max(first - 1, 0) :]
    )
    values = smooth(raw.values, window)
    return Columns(values, raw.rows, raw.cols, raw.shape), smooth(tau[cut], window)


def fit(machine: Machine, logs: Sequence[Log], settle: float = 1.0) -> Fit:
    """Estimate p from logs of one machine; settle [s] at the start of each is left out.

    Raises LogError when no log is given, one is too short, or the motion leaves columns
    at zero (nothing moves).
    """
    if not logs:
        raise LogError("no log given: name at least one run")
    model = MotionModel(machine)
    blocks, torques = [], []
    for log in logs:
        columns, tau = regression(model, log, settle)
        blocks.append(columns.stacked(EVERY))
        torques.append(tau[::EVERY].reshape(-1))
    A, b = np.vstack(blocks), np.concatenate(torques)
    return _solve(machine, A, b)


def _check(machine: Machine, log: Log) -> None:
    n, stroke = machine.n_arms, machine.geometry.stroke
    if log.theta.shape[1] != n:
        raise LogError(f"{log.name}: {log.theta.shape[1]} joints, {machine.name} has {n}")
    largest = float(np.abs(log.theta).max())
    if largest > stroke:
        raise LogError(
            f"{log.name}: an angle of {largest:.4g} rad is beyond the stroke of {stroke:.4g} rad:"
            " are these degrees, or counts?"
        )
    if log.ts > machine.timing.feedforward * (1 + 1e-6):
        raise LogError(
            f"{log.name}: a sample every {log.ts:.4g} s is too slow, at most"
            f" {machine.timing.feedforward:.4g} s: is `time` in seconds?"
        )


def correlation_time(residual: Array) -> float:
    """Samples that count as one: 1 + 2 sum_k rho_k up to the first negative rho, mean of joints.

    Neighbouring smoothed samples repeat each other, and so does what the model lacks; without
    this factor the standard deviations would be far too small.
    """
    n = len(residual)
    centred = residual - residual.mean(axis=0)
    spectrum = np.fft.rfft(centred, 2 * n, axis=0)
    rho = np.fft.irfft(np.abs(spectrum) ** 2, axis=0)[:n]
    rho /= np.maximum(rho[0], 1e-300)
    totals = []
    for column in rho.T:
        negative = np.flatnonzero(column < 0)
        end = negative[0] if len(negative) else n
        totals.append(1 + 2 * float(column[1:end].sum()))
    return float(np.mean(totals))


def _solve(machine: Machine, A: Array, b: Array) -> Fit:
    listed = parameters(machine)
    size = np.linalg.norm(A, axis=0)
    still = [par.name for par, s in zip(listed, size, strict=True) if s == 0]
    if still:
        raise LogError(
            f"the logs do not excite {len(still)} parameters ({', '.join(still[:4])} ...):"
            " use a trajectory that moves all joints"
        )
    # |R| b in one QR factorisation of [A b]: 5 times cheaper than forming Q
    R = np.asarray(np.linalg.qr(np.column_stack([A / size, b]), mode="r"), dtype=float)
    triangle, rhs = R[:-1, :-1], R[:-1, -1]
    p = np.linalg.solve(triangle, rhs) / size
    residual = (b - A @ p).reshape(-1, machine.n_arms)
    rms = np.sqrt((residual**2).mean(axis=0))
    inverse = np.linalg.inv(triangle)
    variance = (residual**2).mean() * correlation_time(residual)
    std = np.sqrt(variance * (inverse**2).sum(axis=1)) / size
    floors = np.array([max(abs(v), par.floor) for v, par in zip(p, listed, strict=True)])
    loose = tuple(par.name for par, s, f in zip(listed, std, floors, strict=True) if s > f)
    return Fit(p, std, rms, float(np.linalg.cond(triangle)), b.size, loose)
