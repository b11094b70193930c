"""Least-squares estimate of the 162 parameters from logs: the paper's "predetermined" p-hat.

    Phi p = tau for all samples of all logs                    [SH, Eq. (25), V-A case 2]

Columns and torque pass the same Hann window; every tenth of the smoothed samples is used (fewer
of long logs), and the normalised columns are solved by orthogonal factorisation. A fit that no
machine of this kind could give is refused: see `plausible`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.motion import MotionModel, SparseRegressor, motion_model
from flexhex.diagnosis.estimation.plausible import listed_names, moving, plausible
from flexhex.diagnosis.estimation.rows import parts, row_step
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters

Array = NDArray[np.float64]
EVERY = 10
"""Samples of the smoothed signals between two rows of the fit: 5 ms of a 50 ms window."""
MOST_ROWS = 40_000
"""Rows of a fit for each joint; of longer logs fewer samples are used. 200 s at 2 kHz."""
SETTLE = 2.0
"""What is left out at the start of each log [s]."""
WORST_CONDITION = 1e7
"""A trajectory that moves all joints apart has 1e4; beyond this p is the noise's."""
TOLERANCE = 0.2
"""Of the machine file's values, where a fit is to be had all the same: an extended machine may have
parameters that no usual trajectory tells from its others."""


@dataclass(frozen=True)
class Fit:
    """p (n_p,) with standard deviations, and how well it explains the logs.

    residual_rms (n,) [N m] for each joint after smoothing; condition: of the normalised
    columns; samples: number of torque values used; undetermined: names of parameters
    whose 95 % interval is wider than their size; warnings: sentences for the reader;
    covariance: of p (n_p, n_p).
    """

    p: Array
    std: Array
    residual_rms: Array
    condition: float
    samples: int
    undetermined: tuple[str, ...]
    warnings: tuple[str, ...] = field(default=())
    covariance: Array | None = field(default=None, repr=False)


def regression(model: MotionModel, log: Log, settle: float) -> tuple[SparseRegressor, Array]:
    """Smoothed columns and torque (samples, n) of one log, its first `settle` s left out."""
    (rows,) = parts(model, log, settle, part=len(log.theta))
    return rows.columns, rows.tau


def fit(
    machine: Machine,
    logs: Sequence[Log],
    settle: float = SETTLE,
    tolerance: float | None = None,
) -> Fit:
    """Estimate p from logs of one machine; settle [s] at the start of each is left out.

    tolerance: where the logs cannot tell the parameters apart, one standard deviation of the
    machine file's values beside them, relative to these or to a parameter's floor. None: such logs
    are refused.

    Raises LogError when no log is given, one is too short, joints stand still, or the result
    is none that a machine could have.
    """
    if not logs:
        raise LogError("no log given: name at least one run")
    moving(machine, logs, settle)
    model = motion_model(machine)
    thin = spacing(machine, logs)
    R = np.zeros((0, model.model.n_p + 1))
    kept: list[tuple[SparseRegressor, Array]] = []
    for log in logs:
        for rows in parts(model, log, settle, every=thin(log)):
            chosen = np.flatnonzero(rows.usable)
            c = rows.columns
            picked, tau = (
                SparseRegressor(c.values[chosen], c.rows, c.cols, c.shape),
                rows.tau[chosen],
            )
            if len(chosen):
                block = np.column_stack([picked.stacked(1), tau.reshape(-1)])
                R = np.asarray(np.linalg.qr(np.vstack([R, block]), mode="r"))
                kept.append((picked, tau))
    if len(R) <= model.model.n_p:
        raise LogError(
            f"{logs[0].name}: {len(R)} usable torque values for {model.model.n_p} parameters:"
            " too much of the log is filled, clipped or cut"
        )
    confounded = _confounded(machine, R)
    if not confounded:
        return _solve(machine, R, kept)
    if tolerance is None:
        raise LogError(f"{confounded}: use a trajectory that moves all joints differently")
    estimate = _solve(machine, _beside_file(machine, R, kept, tolerance), kept)
    warning = f"{confounded}: they are kept near the machine file's, {tolerance:.0%} of each"
    return replace(estimate, warnings=(*estimate.warnings, warning))


def spacing(machine: Machine, logs: Sequence[Log]) -> Callable[[Log], int]:
    """Samples of a log between two rows of the fit, for each log: every tenth at the feedforward's
    rate and as far apart in seconds at any other, farther where the logs are long."""
    near = EVERY * machine.timing.feedforward
    seconds = sum(len(log.theta) * log.ts for log in logs)
    apart = near * max(1, round(seconds / near / MOST_ROWS))
    return lambda log: max(1, round(apart / row_step(machine, log)))


def _beside_file(
    machine: Machine, R: Array, kept: Sequence[tuple[SparseRegressor, Array]], tolerance: float
) -> Array:
    """The triangle R with a row for every value of the machine file, in the noise of the others."""
    file, floors = base_parameters(machine), [par.floor for par in parameters(machine)]
    deviation = tolerance * np.maximum(np.abs(file), floors)
    scaled = R[:, :-1] * deviation
    p = np.linalg.lstsq(scaled, R[:, -1])[0] * deviation
    residual = np.concatenate([tau - predicted(columns, p) for columns, tau in kept])
    weight = np.sqrt((residual**2).mean() * correlation_time(residual)) / deviation
    rows = np.column_stack([np.diag(weight), weight * file])
    return np.asarray(np.linalg.qr(np.vstack([R, rows]), mode="r"))


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


def _solve(machine: Machine, R: Array, kept: Sequence[tuple[SparseRegressor, Array]]) -> Fit:
    """p from the triangle R (n_p + 1, n_p + 1) of [Phi tau]; kept: the rows, for the residual."""
    triangle, size = _normalised(R)
    rhs, condition = R[: len(size), -1], float(np.linalg.cond(triangle))
    p = np.linalg.solve(triangle, rhs) / size
    residual = np.concatenate([tau - predicted(columns, p) for columns, tau in kept])
    tau = np.concatenate([tau for _, tau in kept])
    dead = np.flatnonzero(np.ptp(tau, axis=0) == 0)
    if len(dead):
        raise LogError(f"tau_meas[{dead[0] + 1}] is constant in the logs: is it connected?")
    rms = np.sqrt((residual**2).mean(axis=0))
    inverse = np.linalg.inv(triangle)
    variance = (residual**2).mean() * correlation_time(residual)
    std = np.sqrt(variance * (inverse**2).sum(axis=1)) / size
    covariance = variance * (inverse @ inverse.T) / np.outer(size, size)
    explained = 1 - float(np.sqrt((residual**2).mean()) / max(_spread(tau), 1e-300))
    warnings = plausible(machine, p, std, explained)
    nominal, listed = np.abs(base_parameters(machine)), parameters(machine)
    scales = np.maximum(np.minimum(np.abs(p), nominal), [par.floor for par in listed])
    loose = tuple(par.name for par, s, f in zip(listed, std, scales, strict=True) if 2 * s > f)
    return Fit(p, std, rms, condition, residual.size, loose, warnings, covariance)


def predicted(columns: SparseRegressor, p: Array) -> Array:
    """Phi p (samples, n) [N m]."""
    tau = np.zeros((len(columns.values), columns.shape[0]))
    for joint in range(columns.shape[0]):
        mine = columns.rows == joint
        tau[:, joint] = columns.values[:, mine] @ p[columns.cols[mine]]
    return tau


def _spread(tau: Array) -> float:
    return float(np.sqrt(((tau - tau.mean(axis=0)) ** 2).mean()))


def _normalised(R: Array) -> tuple[Array, Array]:
    """The triangle's columns (n_p, n_p), each of length one, and their lengths (n_p,)."""
    size = np.linalg.norm(R[:, :-1], axis=0)
    return R[: len(size), :-1] / size, size


def _confounded(machine: Machine, R: Array) -> str:
    """Which parameters logs with the triangle R cannot tell apart; or nothing. LogError where they
    do not excite some at all."""
    names = listed_names(machine)
    still = [n for n, s in zip(names, np.linalg.norm(R[:, :-1], axis=0), strict=True) if s == 0]
    if still:
        raise LogError(
            f"the logs do not excite {len(still)} parameters ({', '.join(still[:4])} ...):"
            " use a trajectory that moves all joints"
        )
    triangle, _ = _normalised(R)
    condition = float(np.linalg.cond(triangle))
    if condition < WORST_CONDITION:
        return ""
    weakest = np.abs(np.linalg.svd(triangle)[2][-1])
    most = ", ".join(names[k] for k in np.argsort(weakest)[::-1][:4])
    return (
        f"the logs cannot tell the parameters apart (condition {condition:.2g}, at most"
        f" {WORST_CONDITION:.0g}; worst: {most})"
    )
