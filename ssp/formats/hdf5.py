"""Results in HDF5: a group for each rate with its `time` [s], a data set for each signal.

Attributes `unit` and `description` stand at each data set; an array whose elements differ in
their unit has one string for each. Where elements have names, `elements` holds what follows the
array's name (`.x`, `.actuator[1].o`). `meta` holds the provenance, `times` the time in each FMU.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.result import FORMAT, VERSION, Array, FmuTime, Group, Meta, Result, plain

SMALL, CHUNK = 2**16, 8192
"""Bytes below which samples are stored as they are; samples of a compressed chunk."""
TIME = "time"


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails."""
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": FORMAT, "version": VERSION})
        file.attrs.update({"duration": result.duration, "wall": result.wall})
        provenance = file.create_group("meta")
        for key in sorted(meta):
            provenance.attrs[key] = meta[key]
        rates = file.create_group("rates")
        for name, group in result.groups.items():
            target = rates.create_group(name)
            target.attrs.update({"period": group.period, "base_step": group.base})
            _describe(stored(target, TIME, group.time), ["s"], "time")
            for signal, values in group.signals.items():
                units = group.column_units(signal)
                units = units[:1] if len(set(units)) == 1 else units
                text = group.descriptions.get(signal, "")
                data = stored(target, signal, values)
                _describe(data, units, text)
                if signal in group.elements:
                    data.attrs["elements"] = np.array(group.elements[signal], h5py.string_dtype())
        times = file.create_group("times")
        for name, spent in result.times.items():
            times.create_group(name).attrs.update(vars(spent))


def _describe(data: h5py.Dataset, units: list[str], description: str) -> None:
    strings = np.array(units, dtype=h5py.string_dtype())
    data.attrs["unit"] = units[0] if len(units) == 1 else strings
    data.attrs["description"] = description


def stored(group: h5py.Group, name: str, values: Array) -> h5py.Dataset:
    """A new data set; a large one in compressed chunks, each of one column.

    The filters are those that every program has which reads HDF5 (shuffle, gzip); compressed
    here, since HDF5 knows no deflate by runs alone, which takes half the time. Which of two ways is
    the smaller one is tried in the middle of each column: at its begin a machine may rest.
    """
    if values.nbytes < SMALL:
        return group.create_dataset(name, data=values)
    table, rows = values.reshape(len(values), -1), min(len(values), CHUNK)
    middle = slice((len(table) - rows) // 2, (len(table) + rows) // 2)
    tried = [np.ascontiguousarray(column[middle]) for column in table.T]
    sizes = [sum(len(deflated(chunk)) for chunk in tried) for deflated in (_shuffled, _as_it_is)]
    shuffle = sizes[0] <= sizes[1]
    data = group.create_dataset(
        name,
        values.shape,
        values.dtype,
        chunks=(rows, *[1] * (values.ndim - 1)),
        shuffle=shuffle,
        compression="gzip",
    )
    deflated = _shuffled if shuffle else _as_it_is
    for column in range(table.shape[1]):
        for first in range(0, len(table), rows):
            chunk = np.zeros(rows)
            chunk[: len(table) - first] = table[first : first + rows, column]
            place = (first, column)[: values.ndim]
            data.id.write_direct_chunk(place, deflated(chunk))
    return data


def _shuffled(chunk: Array) -> bytes:
    """Bytes of the samples, all first ones first, then all second ones ..., deflated by runs: for
    samples that change little from one to the next."""
    sorted_bytes = chunk.view(np.uint8).reshape(-1, chunk.itemsize).T
    return _deflated(sorted_bytes.tobytes(), zlib.Z_RLE)


def _as_it_is(chunk: Array) -> bytes:
    """The samples, deflated: for those of few different values, as a drive's current steps."""
    return _deflated(chunk.tobytes(), zlib.Z_DEFAULT_STRATEGY)


def _deflated(data: bytes, strategy: int) -> bytes:
    packer = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, strategy)
    return packer.compress(data) + packer.flush()


def read(path: Path) -> Result:
    """Read a result, also one of an earlier version without `time`. LogError when it is none."""
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise LogError(f"{path}: an HDF5 file, but not a result of flexhex simulate")
            if file.attrs["version"] != VERSION:
                raise LogError(
                    f"{path}: version {file.attrs['version']} of the format, this program reads"
                    f" {VERSION}: simulate anew or take the program that wrote it"
                )
            return _read(file)
    except (OSError, KeyError, RuntimeError) as error:
        raise LogError(f"{path}: not a readable HDF5 result, maybe truncated") from error


def _read(file: h5py.File) -> Result:
    groups = {}
    for name, source in file["rates"].items():
        signals = {signal: data for signal, data in source.items() if signal != TIME}
        groups[name] = Group(
            int(source.attrs["period"]),
            float(source.attrs["base_step"]),
            {signal: np.asarray(data[()], dtype=np.float64) for signal, data in signals.items()},
            {signal: _unit(data.attrs["unit"]) for signal, data in signals.items()},
            {signal: str(data.attrs["description"]) for signal, data in signals.items()},
            {
                signal: tuple(map(str, data.attrs["elements"]))
                for signal, data in signals.items()
                if "elements" in data.attrs
            },
        )
    times = {name: _time(group.attrs) for name, group in file["times"].items()}
    meta = {key: plain(value) for key, value in file["meta"].attrs.items()}
    duration, wall = float(file.attrs["duration"]), float(file.attrs["wall"])
    return Result(groups, times, duration, wall, meta)


def _unit(attribute: Any) -> str:
    return attribute if isinstance(attribute, str) else ",".join(map(str, attribute))


def _time(attributes: Any) -> FmuTime:
    return FmuTime(
        float(attributes["seconds"]),
        float(attributes["worst"]),
        int(attributes["steps"]),
        int(attributes["warnings"]),
        str(attributes["warning"]),
    )
