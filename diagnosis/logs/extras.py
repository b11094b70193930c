"""Parquet and MDF4 logs, where the packages that read them are installed."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from diagnosis.logs.hdf5 import table_of
from diagnosis.logs.log import Finding, Options
from diagnosis.logs.raw import Raw, channel_of, split_unit
from fmus.common.errors import LogError


def _package(path: Path, module: str, extra: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.split(".")[0]
        raise LogError(
            f"{path}: reading {path.suffix} needs the package {package}:"
            f" pip install 'flexhex[{extra}]'"
        ) from None


def read_parquet(path: Path, options: Options) -> Raw:
    """Columns as in CSV; `unit` in a field's metadata, the rest in the file's."""
    parquet = _package(path, "pyarrow.parquet", "parquet")
    try:
        file = parquet.ParquetFile(path)
        schema = file.schema_arrow
        fields = {field.name: field for field in schema}
        named = {name: split_unit(name) for name in fields}
        wanted = [n for n in fields if _wanted(named[n][0], options)]
        table = file.read(columns=wanted)
        data = {named[n][0]: table.column(n).to_numpy(zero_copy_only=False) for n in wanted}
    except Exception as error:  # pyarrow's own classes
        raise LogError(f"{path}: not a readable Parquet file ({error})") from None
    units = {}
    for name in wanted:
        noted = {k.decode(): v.decode() for k, v in (fields[name].metadata or {}).items()}
        units[named[name][0]] = noted.get("unit", noted.get("units", named[name][1]))
    meta = {
        key.decode(): value.decode(errors="replace")
        for key, value in (schema.metadata or {}).items()
        if key not in (b"ARROW:schema", b"pandas")
    }
    return _one(path, [("", data)], units, meta, options)


def read_mdf(path: Path, options: Options) -> Raw:
    """Each channel group of an MDF file is a table with its own master clock."""
    asammdf = _package(path, "asammdf", "mdf")
    groups, units = [], {}
    try:
        with asammdf.MDF(path) as file:
            for index, group in enumerate(file.groups):
                data: dict[str, Any] = {}
                for channel in group.channels:
                    if channel.channel_type in (2, 3) or not _wanted(channel.name, options):
                        continue
                    signal = file.get(channel.name, group=index)
                    data[channel.name] = np.asarray(signal.samples)
                    data["time"] = np.asarray(signal.timestamps)
                    units[channel.name] = str(signal.unit)
                if data:
                    groups.append((f"group {index}", data))
            meta = {"comment": str(file.header.comment)}
    except Exception as error:  # asammdf's own classes
        raise LogError(f"{path}: not a readable MDF file ({error})") from None
    units["time"] = "s"
    return _one(path, groups, units, meta, options)


def _wanted(name: str, options: Options) -> bool:
    return name.lower() in ("time", "t") or bool(channel_of(name, options)[0])


def _one(
    path: Path,
    groups: list[tuple[str, dict[str, Any]]],
    units: dict[str, str],
    meta: dict[str, str],
    options: Options,
) -> Raw:
    tables, findings = [], list[Finding]()
    for name, data in groups:
        where = f"{path}: {name}" if name else str(path)
        table, notes = table_of(where, data, units, options)
        findings += notes
        tables += [table] if table else []
    if not tables:
        raise LogError(f"{path}: no channel `time` in it")
    return Raw(tables, meta, findings)
