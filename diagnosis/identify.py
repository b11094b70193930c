"""Least-squares estimate of the 162 parameters from logs: the paper's "predetermined" p-hat.

    Phi p = tau for all samples of all logs                    [SH, Eq. (25), V-A case 2]

Columns and torque pass the same Hann window; every tenth of the smoothed samples is used (fewer
of long logs), and the normalised columns are solved by orthogonal factorisation. A fit that no
machine of this kind could give is refused: see `_refuse`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.motion import Columns, MotionModel
from flexhex.diagnosis.rows import checked, long_enough, parts
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
LEAST_EXPLAINED, WELL_EXPLAINED = 0.75, 0.95
"""Shares of the torque's RMS about its mean: with less the model is not of this machine, or is
doubtful."""
SCALED = 1.6
"""Ratio of fitted to nominal inertias that is worth a word."""
MASSIVE = (".m", ".J", ".J_xx", ".J_yy", ".J_zz")
"""Endings of masses and inertias; those of the regrouped lower arms may be negative."""
SURE = 4.0
"""Standard deviations by which a mass must be negative to be refused."""


@dataclass(frozen=True)
class Fit:
    """p (n_p,) with standard deviations, and how well it explains the logs.

    residual_rms (n,) [N m] for each joint after smoothing; condition: of the normalised
    columns; samples: number of torque values used; undetermined: names of parameters
    whose 95 % interval is wider than their size; warnings: sentences for the reader.
    """

    p: Array
    std: Array
    residual_rms: Array
    condition: float
    samples: int
    undetermined: tuple[str, ...]
    warnings: tuple[str, ...] = field(default=())


def regression(model: MotionModel, log: Log, settle: float) -> tuple[Columns, Array]:
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
    _moving(machine, logs, settle)
    model = MotionModel(machine)
    samples = sum(len(log.theta) * log.ts for log in logs) / machine.timing.feedforward
    every = EVERY * max(1, round(samples / EVERY / MOST_ROWS))
    R = np.zeros((0, model.model.n_p + 1))
    kept: list[tuple[Columns, Array]] = []
    for log in logs:
        for rows in parts(model, log, settle):
            chosen = np.flatnonzero(rows.usable[::every]) * every
            c = rows.columns
            picked, tau = Columns(c.values[chosen], c.rows, c.cols, c.shape), rows.tau[chosen]
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
    found = _solve(machine, _beside_file(machine, R, kept, tolerance), kept)
    told = f"{confounded}: they are kept near the machine file's, {tolerance:.0%} of each"
    return replace(found, warnings=(*found.warnings, told))


def _beside_file(
    machine: Machine, R: Array, kept: Sequence[tuple[Columns, Array]], tolerance: float
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


def _moving(machine: Machine, logs: Sequence[Log], settle: float) -> None:
    """LogError when a joint stands still, or two cannot be told apart."""
    spans = []
    for log in logs:
        checked(machine, log)
        long_enough(machine, log, settle)
        angle = log["theta"]
        used = angle.valid.copy()
        used[: int(settle / angle.ts)] = False
        if used.any():
            spans.append(np.ptp(angle.values[used], axis=0))
    if not spans:
        raise LogError(f"{logs[0].name}: nothing is left after {settle:.3g} s: too short")
    span, least = np.max(spans, axis=0), machine.actuator.sigma
    still = np.flatnonzero(span < least)
    if len(still):
        raise LogError(
            f"{logs[0].name}: theta[{still[0] + 1}] moves by {span[still[0]]:.3g} rad only,"
            f" {len(still)} of {len(span)} joints by less than {least:.3g} rad: use a trajectory"
            " that moves all joints"
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


def _solve(machine: Machine, R: Array, kept: Sequence[tuple[Columns, Array]]) -> Fit:
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
    explained = 1 - float(np.sqrt((residual**2).mean()) / max(_spread(tau), 1e-300))
    warnings = _refuse(machine, p, std, explained)
    nominal, listed = np.abs(base_parameters(machine)), parameters(machine)
    scales = np.maximum(np.minimum(np.abs(p), nominal), [par.floor for par in listed])
    loose = tuple(par.name for par, s, f in zip(listed, std, scales, strict=True) if 2 * s > f)
    return Fit(p, std, rms, condition, residual.size, loose, warnings)


def listed_names(machine: Machine) -> list[str]:
    """Names of p."""
    return [par.name for par in parameters(machine)]


def predicted(columns: Columns, p: Array) -> Array:
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


def _refuse(machine: Machine, p: Array, std: Array, explained: float) -> tuple[str, ...]:
    """LogError for a negative mass or inertia, or a torque that the model does not explain."""
    names = listed_names(machine)
    massive = [n.endswith(MASSIVE) and not n.startswith("lower.") for n in names]
    positive = [n.startswith(("c[", "d[", "flexure.")) for n in names]
    negative = p + SURE * std < 0
    bad = [n for n, heavy, less in zip(names, massive, negative, strict=True) if heavy and less]
    odd = [n for n, wanted, less in zip(names, positive, negative, strict=True) if wanted and less]
    if bad:
        turned = " Is the sign of the torque turned?" if len(bad) + len(odd) > 1 else ""
        raise LogError(
            f"the fit gives a negative {', '.join(bad[:4])}: the logs are not of {machine.name},"
            f" or a channel is wrong.{turned}"
        )
    if explained < LEAST_EXPLAINED:
        raise LogError(
            f"the model of {machine.name} explains only {max(explained, 0):.0%} of the torque:"
            " the logs are not of this machine, or channels are swapped"
        )
    warnings = [f"{', '.join(odd)}: negative, though no machine has it so"] if odd else []
    ratio = float(np.median(p[massive] / base_parameters(machine)[massive]))
    if not 1 / SCALED < ratio < SCALED:
        warnings.append(
            f"masses and inertias are {ratio:.2g} times those of {machine.name}: is the torque"
            " constant right?"
        )
    if explained < WELL_EXPLAINED:
        warnings.append(f"the model explains {explained:.0%} of the torque: is this its machine?")
    return tuple(warnings)
