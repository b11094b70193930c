"""Results of a run: one group per rate, never merged; kept in HDF5 with what made them."""

from __future__ import annotations

import contextlib
import platform
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.wiring import unknown

FORMAT = "flexhex-result"
VERSION = 1
SMALL, CHUNK = 2**16, 8192
"""Bytes below which samples are stored as they are; samples of a compressed chunk."""
Array = npt.NDArray[np.float64]
Meta = Mapping[str, str | int | float]


@dataclass(frozen=True)
class FmuTime:
    """Time spent in one FMU: all and the worst step [s], steps; warnings, the first in words."""

    seconds: float
    worst: float
    steps: int
    warnings: int
    warning: str = ""


@dataclass(frozen=True)
class Group:
    """Signals of one rate. period in base steps, base [s].

    signals: `plant.theta` (n, 6) or `plant.fault` (n,); row k is what others see at
    k period base steps. units, descriptions: by the same names.
    """

    period: int
    base: float
    signals: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    descriptions: Mapping[str, str] = field(default_factory=dict)

    @property
    def Ts(self) -> float:
        """Sample time [s]."""
        return self.period * self.base

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(next(iter(self.signals.values()))) if self.signals else 0

    @property
    def time(self) -> Array:
        """Time axis (n,) [s], from integer counts."""
        counts = np.arange(self.rows, dtype=np.int64) * self.period
        return np.asarray(counts * self.base, dtype=np.float64)


@dataclass(frozen=True)
class Result:
    """What a run gave: groups by rate name (`0.25ms`), times by component, what made it."""

    groups: Mapping[str, Group]
    times: Mapping[str, FmuTime] = field(default_factory=dict)
    duration: float = 0.0
    wall: float = 0.0
    meta: Meta = field(default_factory=dict)

    def group(self, signal: str) -> Group:
        """The group that holds a signal; LogError when none does."""
        for group in self.groups.values():
            if signal in group.signals:
                return group
        names = [name for group in self.groups.values() for name in group.signals]
        raise LogError(f"{unknown('signal', signal, names)}: was it asked for in the run?")

    def __getitem__(self, signal: str) -> Array:
        """Samples of `plant.theta`, (n,) or (n, size)."""
        return self.group(signal).signals[signal]

    def time(self, signal: str) -> Array:
        """Time axis of a signal (n,) [s]."""
        return self.group(signal).time


def rate_name(period: int, base: float) -> str:
    """Name of the group of one rate: `0.25ms`."""
    return f"{period * base * 1e3:.9g}ms"


def provenance(**more: str | int | float) -> dict[str, str | int | float]:
    """Versions of what takes part, with what the caller adds (command, machine, ...)."""
    meta: dict[str, str | int | float] = {"python": platform.python_version()}
    for package in ("flexhex", "casadi", "fmpy", "numpy"):
        try:
            meta[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            meta[package] = "not installed"
    from flexhex.fmugen.compile import version

    meta["compiler"] = version()
    return meta | more


def save(result: Result, path: str | Path, meta: Meta | None = None) -> Path:
    """Write a result; meta is added to what the result knows of its making.

    The file appears when it is complete. Raises LogError when it cannot be written.
    """
    target = Path(path)
    partial = target.with_name(target.name + ".part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with h5py.File(partial, "w") as file:
            _write(file, result, {**result.meta, **(meta or {})})
        return partial.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise LogError(f"{target}: cannot be written ({error})") from None


def _write(file: h5py.File, result: Result, meta: Meta) -> None:
    file.attrs.update({"format": FORMAT, "version": VERSION})
    file.attrs.update({"duration": result.duration, "wall": result.wall})
    made = file.create_group("meta")
    for key in sorted(meta):
        made.attrs[key] = meta[key]
    rates = file.create_group("rates")
    for name, group in result.groups.items():
        target = rates.create_group(name)
        target.attrs.update({"period": group.period, "base_step": group.base})
        for signal, values in group.signals.items():
            data = _stored(target, signal, values)
            data.attrs["unit"] = group.units.get(signal, "")
            data.attrs["description"] = group.descriptions.get(signal, "")
    times = file.create_group("times")
    for name, spent in result.times.items():
        times.create_group(name).attrs.update(vars(spent))


def _stored(group: h5py.Group, name: str, values: Array) -> h5py.Dataset:
    """A new data set; a large one in compressed chunks, each of one column.

    The filters are those that every program has which reads HDF5 (shuffle, gzip); compressed
    here, since HDF5 knows no deflate by runs alone, which takes half the time.
    """
    if values.nbytes < SMALL:
        return group.create_dataset(name, data=values)
    table, rows = values.reshape(len(values), -1), min(len(values), CHUNK)
    data = group.create_dataset(
        name,
        values.shape,
        values.dtype,
        chunks=(rows, *[1] * (values.ndim - 1)),
        shuffle=True,
        compression="gzip",
    )
    for column in range(table.shape[1]):
        for first in range(0, len(table), rows):
            chunk = np.zeros(rows)
            chunk[: len(table) - first] = table[first : first + rows, column]
            place = (first, column)[: values.ndim]
            data.id.write_direct_chunk(place, _deflated(chunk))
    return data


def _deflated(chunk: Array) -> bytes:
    """Bytes of the samples, all first ones first, then all second ones ..., deflated by runs."""
    sorted_bytes = chunk.view(np.uint8).reshape(-1, chunk.itemsize).T
    packer = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_RLE)
    return packer.compress(sorted_bytes.tobytes()) + packer.flush()


def load(path: str | Path) -> Result:
    """Read a result. Raises LogError for a missing, broken or foreign file."""
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
    except FileNotFoundError:
        raise LogError(f"{path}: no such file") from None
    except (OSError, KeyError, RuntimeError) as error:
        raise LogError(f"{path}: not a readable HDF5 result, maybe truncated") from error


def _read(file: h5py.File) -> Result:
    groups = {}
    for name, source in file["rates"].items():
        groups[name] = Group(
            int(source.attrs["period"]),
            float(source.attrs["base_step"]),
            {signal: np.asarray(data[()], dtype=np.float64) for signal, data in source.items()},
            {signal: str(data.attrs["unit"]) for signal, data in source.items()},
            {signal: str(data.attrs["description"]) for signal, data in source.items()},
        )
    times = {name: _time(group.attrs) for name, group in file["times"].items()}
    meta = {key: _plain(value) for key, value in file["meta"].attrs.items()}
    duration, wall = float(file.attrs["duration"]), float(file.attrs["wall"])
    return Result(groups, times, duration, wall, meta)


def _time(attributes: Any) -> FmuTime:
    return FmuTime(
        float(attributes["seconds"]),
        float(attributes["worst"]),
        int(attributes["steps"]),
        int(attributes["warnings"]),
        str(attributes["warning"]),
    )


def _plain(value: Any) -> str | int | float:
    """An attribute as Python's own type."""
    plain: str | int | float = value.item() if isinstance(value, np.generic) else str(value)
    return plain
