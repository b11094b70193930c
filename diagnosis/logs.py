"""Measured or simulated runs as logs: angles and torques on one clock.

CSV (comment lines with metadata, a row of names, a row of units) and the HDF5
files that `flexhex run` and `flexhex simulate` write.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.common.errors import LogError

Array = NDArray[np.float64]
UNITS = {"time": "s", "theta": "rad", "tau_meas": "N m", "r": "rad", "tau": "N m", "tau_ff": "N m"}
JITTER = 1e-3
"""Largest deviation of a sample period from their median, relative."""


@dataclass(frozen=True)
class Log:
    """One run: theta, tau (samples, n) [rad], [N m] every ts [s]; meta: what the file says."""

    name: str
    ts: float
    theta: Array
    tau: Array
    meta: Mapping[str, str] = field(default_factory=dict)


def read_log(path: str | Path) -> Log:
    """Read one run; LogError tells file, channel and remedy for whatever is wrong."""
    path = Path(path)
    if not path.is_file():
        raise LogError(f"{path}: no such file")
    if path.suffix in (".h5", ".hdf5"):
        return _read_hdf5(path)
    if path.suffix == ".csv":
        return _read_csv(path)
    raise LogError(f"{path}: unknown kind {path.suffix!r}; write CSV or HDF5 (.csv, .h5)")


def _read_hdf5(path: Path) -> Log:
    from ssp.results import load

    result = load(path)
    meta = {key: str(value) for key, value in result.meta.items()}
    time = result.time("plant.theta")
    return _checked(str(path), time, result["plant.theta"], result["plant.tau_meas"], meta)


def _read_csv(path: Path) -> Log:
    meta: dict[str, str] = {}
    rows: list[list[str]] = []
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        for line in csv.reader(file, skipinitialspace=True):
            if line and line[0].startswith("#"):
                key, _, value = ",".join(line)[1:].partition(":")
                meta[key.strip()] = value.strip()
            elif line:
                rows.append(line)
    if len(rows) < 3:
        raise LogError(f"{path}: no samples: wants a row of names, a row of units, then numbers")
    names, units = [s.strip() for s in rows[0]], [s.strip() for s in rows[1]]
    _check_units(path, names, units)
    try:
        values = np.array(rows[2:], dtype=float)
    except ValueError as error:
        raise LogError(f"{path}: a row of numbers cannot be read: {error}") from None
    column = {name: values[:, k] for k, name in enumerate(names)}
    if "time" not in column:
        raise LogError(f"{path}: no channel `time`; it has {', '.join(names)}")
    theta, tau = (_array(path, column, name) for name in ("theta", "tau_meas"))
    return _checked(str(path), column["time"], theta, tau, meta)


def _check_units(path: Path, names: list[str], units: list[str]) -> None:
    for name, unit in zip(names, units, strict=False):
        wanted = UNITS.get(re.sub(r"\[\d+\]$", "", name))
        if wanted and unit != wanted:
            raise LogError(f"{path}: {name} is in {unit!r}, wanted {wanted!r}: convert it")
    if len(names) != len(units):
        raise LogError(f"{path}: {len(names)} names but {len(units)} units")


def _array(path: Path, column: Mapping[str, Array], name: str) -> Array:
    have = sum(key.startswith(f"{name}[") for key in column)
    missing = [k for k in range(1, have + 1) if f"{name}[{k}]" not in column]
    if missing:
        raise LogError(f"{path}: {name}[{missing[0]}] is missing: number them from 1 without gaps")
    found = [column[f"{name}[{k}]"] for k in range(1, have + 1)]
    if not found:
        raise LogError(f"{path}: no channels {name}[1], {name}[2] ...: name them so")
    return np.column_stack(found)


def _checked(name: str, time: Array, theta: Array, tau: Array, meta: Mapping[str, str]) -> Log:
    for channel, values in (("time", time), ("theta", theta), ("tau_meas", tau)):
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            raise LogError(
                f"{name}: {channel} is not a number in sample {bad[0][0] + 1}"
                f" ({len(bad)} such values): cut these samples out"
            )
    if len(time) < 3:
        raise LogError(f"{name}: {len(time)} samples are too few")
    periods = np.diff(time)
    ts = float(np.median(periods))
    if ts <= 0 or np.abs(periods - ts).max() > JITTER * ts:
        k = int(np.argmax(np.abs(periods - ts)))
        raise LogError(
            f"{name}: time is not evenly spaced: {periods[k]:.6g} s after sample {k + 1},"
            f" {ts:.6g} s elsewhere"
        )
    if theta.shape != tau.shape:
        raise LogError(f"{name}: {theta.shape[1]} angles but {tau.shape[1]} torques")
    return Log(name, ts, theta, tau, meta)
