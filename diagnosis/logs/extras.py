"""Parquet and MDF4 logs, where the packages that read them are installed."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.logs.hdf5 import table_of
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.raw import Raw, channel_of, split_unit
from flexhex.fmus.common.errors import LogError


def installed(path: Path, module: str, extra: str) -> Any:
    """A module that reads a file. LogError where it is not installed, naming the extra."""
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.split(".")[0].replace("_", "-")
        raise LogError(
            f"{path}: reading {path.suffix} needs the package {package}:"
            f" pip install 'flexhex[{extra}]'"
        ) from None


def read_parquet(path: Path, options: Options) -> Raw:
    """Columns as in CSV; `unit` in a field's metadata, the rest in the file's."""
    parquet = installed(path, "pyarrow.parquet", "parquet")
    try:
        file = parquet.ParquetFile(path)
        schema = file.schema_arrow
        fields = {field.name: field for field in schema}
        named = {name: split_unit(name) for name in fields}
        wanted = [n for n in fields if _wanted(named[n][0], options)]
        table = file.read(columns=wanted)
        data = {named[n][0]: _numbers(table.column(n)) for n in wanted}
    except Exception as error:  # pyarrow's own classes
        raise LogError(f"{path}: not a readable Parquet file ({error})") from None
    units = {}
    for name in wanted:
        noted = {k.decode(): v.decode() for k, v in (fields[name].metadata or {}).items()}
        units[named[name][0]] = noted.get("unit", noted.get("units", named[name][1]))
    for name, values in data.items():
        if values.dtype.kind in "Mm":
            data[name], units[name] = _seconds(values), "s"
        elif values.dtype.kind not in "fiub":
            raise LogError(f"{path}: {name} holds no numbers ({values.dtype}): write it as double")
    meta = {
        key.decode(): value.decode(errors="replace")
        for key, value in (schema.metadata or {}).items()
        if key not in (b"ARROW:schema", b"pandas")
    }
    return as_tables(path, [("", data)], units, meta, options, list(fields))


def _numbers(column: Any) -> Any:
    """A column as an array: (rows,), or (rows, n) where each row is a list of n numbers."""
    values = column.to_numpy(zero_copy_only=False)
    lists = values.dtype.kind == "O" and len(values) and isinstance(values[0], np.ndarray)
    if lists and len({len(row) for row in values if row is not None}) == 1:
        return np.stack(values)
    return values


def _seconds(stamps: Any) -> Any:
    """Dates or durations as seconds since the first; what is missing is not a number."""
    since = stamps - stamps[~np.isnat(stamps)][:1] if stamps.dtype.kind == "M" else stamps
    return since / np.timedelta64(1, "s")


def read_mdf(path: Path, options: Options) -> Raw:
    """Channel groups of an MDF file with the same master clock are one table."""
    asammdf = installed(path, "asammdf", "mdf")
    groups: list[tuple[str, dict[str, Any]]] = []
    units: dict[str, str] = {}
    names: list[str] = []
    try:
        with asammdf.MDF(path) as file:
            for index, group in enumerate(file.groups):
                data: dict[str, Any] = {}
                names += [channel.name for channel in group.channels]
                for channel in group.channels:
                    if channel.channel_type in (2, 3) or not _wanted(channel.name, options):
                        continue
                    signal = file.get(channel.name, group=index)
                    data[channel.name] = np.asarray(signal.samples)
                    data["time"] = np.asarray(signal.timestamps)
                    units[channel.name] = str(signal.unit)
                if data:
                    _beside(groups, f"group {index}", data)
            meta = {"comment": str(file.header.comment)}
    except Exception as error:  # asammdf's own classes
        raise LogError(f"{path}: not a readable MDF file ({error})") from None
    units["time"] = "s"
    return as_tables(path, groups, units, meta, options, names)


def _beside(groups: list[tuple[str, dict[str, Any]]], name: str, data: dict[str, Any]) -> None:
    """Put channels to those with the same instants: many tools write a group for each signal."""
    for _, known in groups:
        if not set(known) & set(data) - {"time"} and np.array_equal(known["time"], data["time"]):
            known.update(data)
            return
    groups.append((name, data))


def _wanted(name: str, options: Options) -> bool:
    return name.lower() in ("time", "t") or bool(channel_of(name, options)[0])


def as_tables(
    path: Path,
    groups: list[tuple[str, dict[str, Any]]],
    units: dict[str, str],
    meta: dict[str, str],
    options: Options,
    names: list[str],
) -> Raw:
    """Groups of channels, each with its time, as tables. LogError where none of them is known."""
    tables, findings = [], list[Finding]()
    for name, data in groups:
        where = f"{path}: {name}" if name else str(path)
        table, notes = table_of(where, data, units, options)
        findings += notes
        tables += [table] if table else []
    if not tables:
        shown = ", ".join(names[:12]) or "no channels"
        raise LogError(
            f"{path}: none of its channels is known beside a time; it has {shown}:"
            " name them with --rename NAME=CHANNEL (time, theta[1], tau_meas[1] ...)"
        )
    return Raw(tables, meta, findings)
