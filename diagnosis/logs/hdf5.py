"""HDF5 logs, plain ones and the results of `flexhex run` and `flexhex simulate`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flexhex.diagnosis.logs.log import Array, Finding, Options
from flexhex.diagnosis.logs.raw import Column, Plan, Raw, Table, joins_of, picked, plan
from flexhex.fmus.common.errors import LogError
from flexhex.ssp.results import FORMAT, VERSION

OURS = {
    "theta": "plant.theta",
    "tau_meas": "plant.tau_meas",
    "r": "reference.r",
    "payload": "reference.payload",
    "tau": "feedback.tau",
    "tau_ff": "F.tau_ff",
}
"""Signals of a result by channel."""


def read_hdf5(path: Path, options: Options) -> Raw:
    """Read an HDF5 log; LogError for a broken one or one without time."""
    try:
        with h5py.File(path, "r") as file:
            if _text(file.attrs.get("format", "")) == FORMAT:
                return _result(path, file, options)
            return _plain(path, file, options)
    except (OSError, KeyError, RuntimeError, TypeError, ValueError) as error:
        raise LogError(f"{path}: not a readable HDF5 result, maybe truncated ({error})") from None


def _result(path: Path, file: h5py.File, options: Options) -> Raw:
    """A result of ours: one table for each rate, its clock counted."""
    if file.attrs["version"] != VERSION:
        raise LogError(
            f"{path}: version {file.attrs['version']} of the format, this program reads"
            f" {VERSION}: simulate anew or take the program that wrote it"
        )
    tables, findings = [], []
    for rate in file["rates"].values():
        period = int(rate.attrs["period"]) * float(rate.attrs["base_step"])
        data = {c: rate[signal] for c, signal in OURS.items() if signal in rate}
        if not data:
            continue
        rows = min(len(values) for values in data.values())
        columns = [
            column
            for name, values in data.items()
            for column in _columns(name, values, rows, _text(values.attrs.get("unit", "")))
        ]
        counted = Column(None, "time", "s")
        table, notes = _table(str(path), plan(str(path), counted, columns, options), rows, options)
        kept, _ = picked(rows, 1 + len(columns), options, str(path))
        table.time = np.concatenate([np.arange(a, b, dtype=np.float64) for a, b in kept]) * period
        tables.append(table)
        findings += notes
    meta = {key: _text(value) for key, value in file["meta"].attrs.items()}
    return Raw(tables, meta, findings)


def _plain(path: Path, file: h5py.File, options: Options) -> Raw:
    """Any other file: root and groups, each with a `time` of its own."""
    groups: list[tuple[str, Any]] = [(str(path), file)]
    file.visititems(
        lambda name, item: (
            groups.append((f"{path}: {name}", item)) if isinstance(item, h5py.Group) else None
        )
    )
    meta: dict[str, str] = {}
    tables, findings = [], []
    for where, group in groups:
        meta.update({key: _text(value) for key, value in group.attrs.items()})
        data = {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)}
        if not data:
            continue
        table, notes = table_of(where, data, units_of(data), options)
        findings += notes
        tables += [table] if table else []
    if not tables:
        raise LogError(f"{path}: no channel `time` in it: each group wants its own")
    return Raw(tables, meta, findings)


def units_of(data: Mapping[str, Any]) -> dict[str, str]:
    """Units of datasets by name from their attributes."""
    units = {}
    for name, item in data.items():
        unit = item.attrs.get("unit", item.attrs.get("units", ""))
        units[name] = _text(unit)
    return units


def table_of(
    where: str, data: Mapping[str, Any], units: Mapping[str, str], options: Options
) -> tuple[Table | None, list[Finding]]:
    """A table of arrays or datasets by name; None without a `time` among them."""
    time = next((n for n in data if options.rename.get(n, n).lower() in ("time", "t")), None)
    if time is None:
        names = ", ".join(list(data)[:6])
        return None, [Finding("extra", where, f"no `time` beside {names}: not used", False)]
    rows = int(np.prod(data[time].shape))
    columns = [
        column
        for name, item in data.items()
        if name != time
        for column in _columns(name, item, rows, units.get(name, ""))
    ]
    clock = Column((data[time], None, False), "time", units.get(time, ""))
    return _table(where, plan(where, clock, columns, options), rows, options)


def _columns(name: str, item: Any, rows: int, unit: str) -> list[Column]:
    """Columns of one array: (rows,), (rows, n) or, as MATLAB writes it, (n, rows)."""
    shape = tuple(item.shape)
    if item.dtype.kind not in "fiub":
        return []
    if len(shape) == 1 and shape[0] == rows:
        return [Column((item, None, False), name, unit)]
    if len(shape) != 2 or rows not in shape:
        return [Column(None, f"{name} {shape}", unit)]
    across = shape[0] != rows
    width = shape[0] if across else shape[1]
    if width == 1:
        return [Column((item, 0, across), name, unit)]
    return [Column((item, k, across), f"{name}[{k + 1}]", unit) for k in range(width)]


def _table(
    where: str, planned: tuple[Plan, list[Finding]], rows: int, options: Options
) -> tuple[Table, list[Finding]]:
    """Read what was planned, in stretches where all of it would be too much."""
    wanted, notes = planned
    parts, more = picked(rows, wanted.columns, options, where)
    size = sum(b - a for a, b in parts)
    time = np.empty(0)
    if wanted.time.key is not None:
        time = np.empty(size)
        _fill(wanted.time.key, parts, time)
    values = {}
    for name, keys in wanted.keys.items():
        values[name] = np.empty((size, len(keys)))
        for axis, key in enumerate(keys):
            _fill(key, parts, values[name][:, axis])
    table = Table(where, time, wanted.time.unit, values, dict(wanted.units), joins_of(parts))
    return table, notes + more


def _fill(key: tuple[Any, int | None, bool], parts: list[tuple[int, int]], to: Array) -> None:
    """Copy the parts of one column of a dataset, a block at a time."""
    item, column, across = key
    done = 0
    for begin, end in parts:
        if column is not None:
            block = item[column, begin:end] if across else item[begin:end, column]
        elif len(item.shape) > 1:
            block = np.asarray(item[()]).ravel()[begin:end]
        else:
            block = item[begin:end]
        to[done : done + end - begin] = block
        done += end - begin


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.ndarray):
        return ", ".join(_text(each) for each in value.ravel())
    return str(value)
