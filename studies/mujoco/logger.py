"""What a logger makes of the runs: noise, steps, delay, another start; and the files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from studies.mujoco.case import Case
from studies.mujoco.effect import Effect
from studies.mujoco.machine import Array
from studies.mujoco.simulate import Record, coloured

MOST_OFFSET = 0.5
"""Latest start of a log [s], and latest start of its clock."""


@dataclass(frozen=True)
class Log:
    """time (samples,) [s], channels (samples, n) by name, heads, whether it is for tests."""

    time: Array
    channels: dict[str, Array]
    meta: dict[str, str]
    test: bool

    @property
    def name(self) -> str:
        """Of its file, without ending."""
        return f"run{int(self.meta['run']):02d}"


def logged(
    case: Case, effects: Sequence[Effect], records: list[list[Record]], scale: Array
) -> list[Log]:
    """Logs of runs [trajectory][pass]; scale (n,): torque RMS that noise is relative to.

    Runs were made pass by pass in the order of the trajectories; the wander goes on from run to
    run."""
    rng = np.random.default_rng([case.noise.seed, 11])
    wander, logs, degrees = rng.standard_normal(case.machine.n), [], float(rng.uniform(18, 30))
    number = 0
    for letter, passes in enumerate(records):
        for k, record in enumerate(passes):
            number += 1
            slow, wander = _wander(case, record, wander, rng)
            degrees += float(rng.uniform(0, 0.4))
            meta = {
                "run": str(number),
                "trajectory": chr(ord("a") + letter),
                "pass": str(k + 1),
                "payload": f"{case.payload:.4g}" if case.announced and heavy(case, k) else "0",
                "temperature": f"{degrees:.1f}",
            }
            test = len(records) > 1 and letter == len(records) - 1
            logs.append(
                _log(case, record, record.misread(effects), slow * scale, scale, meta, test, rng)
            )
    return logs


def heavy(case: Case, k: int) -> bool:
    """Whether pass k has the payload."""
    return case.payload > 0 and k >= case.passes // 2


def _wander(
    case: Case, record: Record, start: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """A slow walk (samples, n) that comes back within `noise.time`; where it ends."""
    pole = float(np.exp(-1 / (case.rate * case.noise.time)))
    kicks = np.sqrt(1 - pole**2) * rng.standard_normal(record.u.shape)
    walk, now = np.empty_like(kicks), start
    for k, kick in enumerate(kicks):
        now = pole * now + kick
        walk[k] = now
    return walk * case.noise.wander, now


def _log(
    case: Case,
    record: Record,
    misread: Array,
    slow: Array,
    scale: Array,
    meta: dict[str, str],
    test: bool,
    rng: np.random.Generator,
) -> Log:
    noise = case.noise.white * rng.standard_normal(record.u.shape)
    corner = min(case.noise.corner / case.rate, 0.2)
    noise += case.noise.coloured * coloured(rng, record.u.shape, corner)
    step = case.noise.torque_step * scale
    late = np.concatenate([np.repeat(record.u[:1], case.delay, axis=0), record.u])[: len(record.u)]
    read = record.q[:, record.at] + misread
    dither = rng.uniform(-0.5, 0.5, read.shape)
    channels = {
        "theta": np.round(read / case.encoder + 0.5 * dither) * case.encoder,
        "tau_meas": np.round((late + noise * scale + slow) / step) * step,
    }
    if case.command:
        channels["tau"] = np.round(record.u / step) * step
    if case.reference:
        channels["r"] = record.r
    first = 0 if case.aligned else int(rng.integers(0, max(1, round(MOST_OFFSET * case.rate))))
    first = min(first, len(record.u) // 8)
    clock = 0.0 if case.aligned else float(rng.uniform(0, MOST_OFFSET))
    time = clock + np.arange(len(record.u) - first) / case.rate
    return Log(time, {name: values[first:] for name, values in channels.items()}, meta, test)


def write(log: Log, path: Path, units: tuple[str, str]) -> None:
    """HDF5 or CSV by the ending of `path`; units of position and torque."""
    of = {"theta": units[0], "r": units[0], "tau_meas": units[1], "tau": units[1]}
    if path.suffix == ".h5":
        with h5py.File(path, "w") as file:
            for name, text in log.meta.items():
                file.attrs[name] = text
            for name, values in {"time": log.time, **log.channels}.items():
                file.create_dataset(name, data=values).attrs["unit"] = of.get(name, "s")
        return
    names, row, columns = ["time"], ["s"], [log.time[:, None]]
    for name, values in log.channels.items():
        names += [f"{name}[{k + 1}]" for k in range(values.shape[1])]
        row += [of[name]] * values.shape[1]
        columns.append(values)
    lines = [f"# {name}: {text}" for name, text in log.meta.items()]
    lines += [",".join(names), ",".join(row)]
    lines += [",".join(f"{v:.12g}" for v in r) for r in np.concatenate(columns, axis=1)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
