"""Reference trajectories as files: what a machine is to follow, ready for its controller.

CSV as for logs: `# key: value` lines, a row of names, a row of units, then time and r[1..n].
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.kinds import ROTARY, Kinds, kinds_of, units_of
from flexhex.diagnosis.logs import Options
from flexhex.diagnosis.logs.clock import clock_of
from flexhex.diagnosis.logs.raw import Raw, Table, no_log
from flexhex.diagnosis.logs.read import READERS
from flexhex.diagnosis.logs.stated import chosen_units
from flexhex.diagnosis.logs.units import factor, kind_of
from flexhex.fmus.common.errors import LogError, unreadable

Array = NDArray[np.float64]
EXTREMES = {"amplitude": "", "speed": "/s", "acceleration": "/s2"}
"""What a file's head says of a motion's size, and what its unit adds to that of the positions."""


@dataclass(frozen=True)
class Trajectory:
    """Angles r (samples, n) [rad, m] every ts [s]; meta: kind and parameters, passes, payloads;
    kinds: of the axes, none where all turn."""

    name: str
    ts: float
    r: Array
    meta: Mapping[str, str] = field(default_factory=dict)
    kinds: Kinds = ()

    @property
    def time(self) -> Array:
        """Instants (samples,) [s]."""
        return np.round(self.ts * np.arange(len(self.r)), 9)


def extremes(motion: tuple[Array, Array, Array], owner: object) -> dict[str, str]:
    """Largest amplitude, speed and acceleration of r, rd, rdd (samples, n) each, as lines for a
    file's head: one number, or one for each axis. owner: whose `kinds` they are."""
    n, lines = motion[0].shape[1], {}
    units = units_of(owner, n, "rad")
    for (name, per), values in zip(EXTREMES.items(), motion, strict=True):
        sizes = [
            f"{size:.3g} {unit}{per}"
            for size, unit in zip(np.abs(values).max(0), units, strict=True)
        ]
        lines[name] = ", ".join(sizes if len(set(sizes)) > 1 else sizes[:1])
    return lines


def write_trajectory(trajectory: Trajectory, path: Path) -> Path:
    """Write a trajectory as CSV; positions are given to 1e-10 rad or m."""
    n = trajectory.r.shape[1]
    lines = [f"# {key}: {value}" for key, value in trajectory.meta.items()]
    lines.append(",".join(["time", *(f"r[{i}]" for i in range(1, n + 1))]))
    lines.append(",".join(["s", *(kind.unit("rad") for kind in kinds_of(trajectory, n))]))
    path.parent.mkdir(parents=True, exist_ok=True)
    table = np.column_stack([trajectory.time, trajectory.r])
    formats = ["%.10g", *["%.10f"] * n]
    with path.open("w", encoding="utf-8", newline="\n") as file:
        np.savetxt(file, table, formats, ",", header="\n".join(lines), comments="")
    return path


def read_trajectory(path: str | Path, options: Options | None = None) -> Trajectory:
    """Read r, or the angles where no r was logged, from a trajectory or a log of any kind."""
    path, options = Path(path), options or Options()
    if not path.is_file():
        missing = IsADirectoryError() if path.is_dir() else FileNotFoundError()
        raise LogError(unreadable(path, missing))
    if path.suffix.lower() not in READERS:
        raise LogError(f"{path}: {no_log(path)}")
    module, function = READERS[path.suffix.lower()]
    reader = getattr(importlib.import_module(f"flexhex.diagnosis.logs.{module}"), function)
    try:
        raw: Raw = reader(path, options)
    except OSError as error:
        raise LogError(unreadable(path, error)) from None
    table, name = _source(path, raw)
    (unit,), _ = chosen_units(table, "time", options.units)
    time = table.time * factor(table.where, "time", unit)
    listed, _ = chosen_units(table, name, options.units)
    values = table.values[name] * [
        factor(table.where, name, u, k) for k, u in enumerate(listed, start=1)
    ]
    kinds = tuple(kind_of(name, unit) or ROTARY for unit in listed)
    channel = clock_of(table.where, time, table.joins).channel(values)
    if not (channel.valid.all() and np.isfinite(channel.values).all()):
        raise LogError(f"{path}: {name} has gaps: a trajectory must be whole")
    meta = {str(key): str(value) for key, value in raw.meta.items()}
    return Trajectory(path.stem, channel.ts, channel.values, meta, kinds)


def _source(path: Path, raw: Raw) -> tuple[Table, str]:
    for name in ("r", "theta"):
        for table in raw.tables:
            if name in table.values:
                return table, name
    raise LogError(f"{path}: no channels r[1], r[2] ...: name them so")
