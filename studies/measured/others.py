"""What a lab would use instead: least squares on filtered signals, terms by BIC, PySINDy.

This is the usual way of the field, written without the diagnosis: positions filtered forth and
back by a Butterworth filter, differences, rows decimated, ordinary least squares.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt

from studies.measured.sets import Measured, Part

Array = NDArray[np.float64]
EDGE = 0.3
"""What is left out at either end of a log, where the filter swings in [s]."""
ROWS = 5.0
"""Rows per second that are kept, for each Hz of the filter's corner."""

STILL = 0.01
"""Rate, relative to an axis' largest, below which it counts as standing still: what holds it there
no model of these says."""


@dataclass(frozen=True)
class Rows:
    """Filtered motion q, v, a and torque (rows, n) of a part, on even times t."""

    t: Array
    q: Array
    v: Array
    a: Array
    tau: Array


def rows(part: Part, cut: float) -> Rows:
    """A part as labs prepare it; cut [Hz]."""
    b, a = butter(4, min(0.99, 2 * cut * part.ts))
    q = filtfilt(b, a, part.q, axis=0)
    v = np.gradient(q, part.ts, axis=0)
    acc = np.gradient(v, part.ts, axis=0)
    tau = filtfilt(b, a, part.tau, axis=0)
    edge, every = round(EDGE / part.ts), max(1, round(1 / (ROWS * cut * part.ts)))
    keep = slice(edge, len(q) - edge, every)
    return Rows(part.t[keep], q[keep], v[keep], acc[keep], tau[keep])


def mechanism(measured: Measured, r: Rows) -> Array:
    """Columns (rows, n, p) of the mechanism alone: bodies by Pinocchio and rotors, or one mass."""
    n = r.q.shape[1]
    rotors = np.eye(n) * r.a[:, :, None]
    if measured.base == "axis":
        return rotors
    pin: Any = importlib.import_module("pinocchio")
    model, data = _robot(measured.base)
    bodies = [
        pin.computeJointTorqueRegressor(model, data, *state)
        for state in zip(r.q, r.v, r.a, strict=True)
    ]
    return np.concatenate([np.array(bodies), rotors], axis=2)


@cache
def _robot(file: str) -> tuple[Any, Any]:
    pin: Any = importlib.import_module("pinocchio")
    model = pin.buildModelFromXML(Path(file).read_text(encoding="utf-8"))
    return model, model.createData()


def terms(r: Rows, axis: int) -> dict[str, Array]:
    """Columns (rows,) that a lab would try on an axis, by name."""
    q, v, a = r.q[:, axis], r.v[:, axis], r.a[:, axis]
    sign = np.sign(v)
    slow = np.exp(-np.abs(v) / (0.1 * np.sqrt(np.mean(v**2))))
    return {
        "sign v": sign,
        "v": v,
        "1": np.ones_like(v),
        "v |v|": v * np.abs(v),
        "v^3": v**3,
        "|v|": np.abs(v),
        "sign v, slow": sign * slow,
        "|a| sign v": np.abs(a) * sign,
        "q": q,
        "q^3": q**3,
        "sin q": np.sin(q),
        "cos q": np.cos(q),
    }


USUAL = ("sign v", "v", "1")
"""Friction and offset, which every lab takes."""


class LeastSquares:
    """Ordinary least squares: the mechanism with these terms of each axis; pair: axes, from 0, that
    one motor turns together, whose rotor and friction both feel."""

    def __init__(
        self,
        measured: Measured,
        chosen: Sequence[Sequence[str]],
        pair: tuple[int, int] | None = None,
    ) -> None:
        self.measured, self.chosen, self.pair = measured, chosen, pair
        fit = [rows(part, measured.cut) for part in measured.fit]
        A = np.concatenate([self.columns(r) for r in fit])
        y = np.concatenate([r.tau for r in fit])
        # axes weigh by the size of their torque; what nothing tells apart has the smallest norm
        weight = 1 / y.std(axis=0)
        left = (A * weight[:, None]).reshape(-1, A.shape[2])
        scale = np.maximum(np.linalg.norm(left, axis=0), 1e-12)
        self.p = np.linalg.lstsq(left / scale, (y * weight).ravel(), rcond=1e-9)[0] / scale

    def columns(self, r: Rows) -> Array:
        """All columns (rows, n, p)."""
        columns, n = [mechanism(self.measured, r)], r.q.shape[1]
        if self.pair is not None:
            both = list(self.pair)
            v, a = r.v[:, both].sum(axis=1), r.a[:, both].sum(axis=1)
            added = np.zeros((len(r.q), n, 3))
            added[:, both] = np.column_stack([a, v, np.sign(v)])[:, None]
            columns.append(added)
        for axis, names in enumerate(self.chosen):
            own = terms(r, axis)
            added = np.zeros((len(r.q), n, len(names)))
            added[:, axis] = np.column_stack([own[name] for name in names])
            columns.append(added)
        return np.concatenate(columns, axis=2)

    def predicted(self, r: Rows) -> Array:
        """Torques (rows, n)."""
        return np.asarray(self.columns(r) @ self.p)


def usual(measured: Measured) -> LeastSquares:
    """Friction and offset on all axes."""
    return LeastSquares(measured, [USUAL] * measured.fit[0].q.shape[1])


def coupled(measured: Measured) -> LeastSquares:
    """The usual terms and those of a motor that turns two axes."""
    return LeastSquares(measured, [USUAL] * measured.fit[0].q.shape[1], measured.coupled)


def by_bic(measured: Measured) -> LeastSquares:
    """Terms that lower BIC = N log(RSS / N) + k log N, axis by axis, one after the other, beside
    what the mechanism with the usual terms leaves."""
    known = usual(measured)
    fit = [rows(part, measured.cut) for part in measured.fit]
    chosen = []
    for axis in range(measured.fit[0].q.shape[1]):
        own = [terms(r, axis) for r in fit]
        listed = {name: np.concatenate([each[name] for each in own]) for name in own[0]}
        rest = np.concatenate([(r.tau - known.predicted(r))[:, axis] for r in fit])
        usual_part = known.p[_place(known, axis)]
        rest = rest + sum(p * listed[name] for p, name in zip(usual_part, USUAL, strict=True))
        chosen.append(_lowest(listed, rest))
    return LeastSquares(measured, chosen)


def _place(known: LeastSquares, axis: int) -> slice:
    first = len(known.p) - len(USUAL) * len(known.chosen) + len(USUAL) * axis
    return slice(first, first + len(USUAL))


def _lowest(listed: dict[str, Array], rest: Array) -> list[str]:
    """Names by forward selection, USUAL first among equals."""

    def bic(names: Sequence[str]) -> float:
        A = np.column_stack([listed[name] for name in names])
        left = rest - A @ np.linalg.lstsq(A, rest, rcond=None)[0]
        return float(len(rest) * np.log(np.mean(left**2)) + len(names) * np.log(len(rest)))

    names, best = list[str](), np.inf
    while len(names) < len(listed):
        each = {name: bic([*names, name]) for name in listed if name not in names}
        name = min(each, key=lambda k: each[k])
        if each[name] >= best:
            break
        best = each[name]
        names.append(name)
    return names


def payload_mass(measured: Measured) -> float:
    """Mass [kg] that the loaded parts carry and the others do not: ten columns more, of the last
    body, in their rows alone."""
    known = usual(measured)
    parts = [(part, part in measured.loaded) for part in (*measured.fit, *measured.loaded)]
    A, y = [], []
    for part, on in parts:
        r = rows(part, measured.cut)
        columns = known.columns(r)
        n = r.q.shape[1]
        last = columns[:, :, 10 * (n - 1) : 10 * n] * on
        A.append(np.concatenate([last, columns], axis=2))
        y.append(r.tau)
    weight = 1 / np.concatenate(y).std(axis=0)
    whole = (np.concatenate(A) * weight[:, None]).reshape(-1, A[0].shape[2])
    scale = np.maximum(np.linalg.norm(whole, axis=0), 1e-12)
    p = np.linalg.lstsq(whole / scale, (np.concatenate(y) * weight).ravel(), rcond=1e-9)[0]
    return float((p / scale)[0])


def relative_rms(predicted: Array, tau: Array, v: Array) -> list[float]:
    """RMS left over RMS of the torque, of each axis in the rows in which it moves."""
    ratios = []
    for own, wanted, rate in zip(predicted.T, tau.T, np.abs(v).T, strict=True):
        on = rate > STILL * rate.max()
        ratios.append(float(np.sqrt(np.mean((own - wanted)[on] ** 2) / np.mean(wanted[on] ** 2))))
    return ratios


def relative(measured: Measured, model: Any, parts: Sequence[Part]) -> list[float]:
    """RMS of what a model leaves of the filtered torque, of each axis, over that torque's RMS."""
    prepared = [rows(part, measured.cut) for part in parts]
    predicted = np.concatenate([model.predicted(r) for r in prepared])
    tau, v = (np.concatenate([getattr(r, name) for r in prepared]) for name in ("tau", "v"))
    return relative_rms(predicted, tau, v)
