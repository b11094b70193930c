"""Logs to one folder, the truth to another; how much of each effect the logs can show."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from studies.generator.base import Columns
from studies.generator.draw import INSIDE, Case
from studies.generator.drives import Drive
from studies.generator.inverse import Clean, Scaled
from studies.generator.logger import UNITS, Run, logged
from studies.generator.trajectories import RATE, WARM
from tests.oracles.calculus import Array

FAMILY = "generator"
JOINTS = 6
STARTS = {
    "payload": ("end_effector", "payload"),
    "stiffness": ("flexure", "k_u", "k_s", "stiffness"),
    "offset": (*(f"actuator[{i}].o" for i in range(1, JOINTS + 1)), "offset"),
    "damping": (*(f"actuator[{i}].d" for i in range(1, JOINTS + 1)), "damping"),
}
"""How a right name of a changed parameter may begin, by what was changed."""
GAINS = {
    "cubic_stiffness": "k_3",
    "drive_lag": "T_lag",
    "flexible_mode": "J_2",
    "time_delay": "T_delay",
}
"""Gains that mean the same in nature and in the library; other forms differ by some percent."""
COGS = 36.0
"""Cogging periods of a turn that the machine has already: the unit of a cogging's order."""


@dataclass(frozen=True)
class Written:
    """Files of a case: logs for the diagnosis, held-out logs, sealed truth."""

    paths: tuple[Path, ...]
    held_out: tuple[Path, ...]
    sealed: Path


def write(case: Case, clean: Clean, logs: Path, sealed: Path, ending: str = "h5") -> Written:
    """Write all logs into the folder `logs` and the truth into the folder `sealed`.

    ValueError when one folder lies in the other: the truth must not stand beside the logs.
    """
    one, two = logs.resolve(), sealed.resolve()
    if one == two or one in two.parents or two in one.parents:
        raise ValueError(f"{sealed}: the truth must lie apart from the logs in {logs}")
    logs.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    open_: list[Path] = []
    held_out: list[Path] = []
    for run in logged(case, clean):
        path = logs / f"{run.name}.{ending}"
        (_csv if ending == "csv" else _hdf5)(run, path)
        (held_out if run.held_out else open_).append(path)
    truth = sealed / f"{case.seed}{'c' if case.closed else ''}.json"
    truth.write_text(json.dumps(truth_of(case, clean), indent=1) + "\n", encoding="utf-8")
    return Written(tuple(open_), tuple(held_out), truth)


def _hdf5(run: Run, path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, value in run.meta.items():
            file.attrs[name] = value
        for name, values in {"time": run.time, **run.channels}.items():
            data = file.create_dataset(name, data=values)
            data.attrs["unit"] = "s" if name == "time" else UNITS[name]


def _csv(run: Run, path: Path) -> None:
    names, units, columns = ["time"], ["s"], [run.time[:, None]]
    for name, values in run.channels.items():
        names += [f"{name}[{k}]" for k in range(1, 7)]
        units += [UNITS[name]] * 6
        columns.append(values)
    rows = np.concatenate(columns, axis=1).tolist()
    lines = [f"# {name}: {value}" for name, value in run.meta.items()]
    lines += [",".join(names), ",".join(units)]
    lines += [",".join(map(repr, row)) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def truth_of(case: Case, clean: Clean) -> dict[str, Any]:
    """The truth as JSON; joints are counted from 1."""
    open_runs = (len(case.trajectories) - 1) * case.passes
    first = np.arange(0, open_runs, case.passes)
    skip = round(WARM * RATE)
    q, v, a = (x[:, first] for x in (clean.q, clean.v, clean.a))
    columns = Columns(clean.base, q, v, a, skip) if clean.scaled else None
    hidden = []
    for scaled, contribution in zip(clean.scaled, clean.contributions, strict=True):
        assert columns is not None
        rms = np.sqrt(np.mean(contribution[:, :open_runs, skip:] ** 2, axis=(1, 2)))
        hidden.append(
            _effect(scaled, rms, _seen(scaled, contribution[:, first], columns), clean.rms)
        )
    return {
        "family": FAMILY,
        "seed": case.seed,
        "machine": "hexapod",
        "category": case.category,
        "closed": case.closed,
        "hidden": hidden,
        "changed": [
            {**asdict(change), "accept": list(STARTS[change.kind]), "announced": False}
            for change in case.changes
        ],
        "torque_rms": clean.rms.tolist(),
        "sigma": case.truth.actuator.sigma,
        "noise": asdict(case.noise),
        "log": asdict(case.log),
        "trajectories": [kind for kind, _ in case.trajectories],
        "passes": case.passes,
        "tracking_rms": float(np.sqrt(np.mean((clean.q - clean.r)[..., skip:] ** 2))),
    }


def _seen(scaled: Scaled, contribution: Array, columns: Columns) -> Array:
    """RMS (6,) of an effect that the base model cannot take up; a drive effect lies between two
    measured channels, where there is nothing to take it up."""
    if isinstance(scaled.effect, Drive):
        return np.asarray(np.sqrt(np.mean(columns.thin(contribution) ** 2, axis=(1, 2))))
    return columns.left(contribution)


def _effect(scaled: Scaled, rms: Array, seen: Array, torque: Array) -> dict[str, Any]:
    axes = list(scaled.hidden.axes)
    whole = np.linalg.norm(torque[axes])
    announced = {
        name: value
        for name, value in vars(scaled.effect).items()
        if isinstance(value, int | float) and name not in ("states", "limit")
    }
    return {
        "id": scaled.hidden.id,
        "accept": [scaled.hidden.id] if scaled.hidden.id in INSIDE else [],
        "inside": scaled.hidden.id in INSIDE,
        "axes": [k + 1 for k in axes],
        "wanted": scaled.hidden.size,
        "size": float(np.linalg.norm(rms[axes]) / whole),
        "observable": float(np.linalg.norm(seen[axes]) / whole),
        "observable_per_axis": (seen / torque).tolist(),
        "gain": scaled.gain[axes].tolist(),
        "unit": scaled.effect.unit,
        "announced": {**announced, **scaled.effect.announced},
        "parameters": _parameters(scaled, announced),
    }


def _parameters(scaled: Scaled, announced: Mapping[str, float]) -> dict[str, Any]:
    """True values of parameters that the library has too, by its names."""
    id, parameters = scaled.hidden.id, dict[str, Any]()
    if id in GAINS:
        gain = scaled.gain[list(scaled.hidden.axes)].tolist()
        parameters[GAINS[id]] = {"value": gain, "unit": scaled.effect.unit}
    if id == "cogging_harmonic":
        parameters["order"] = {"value": COGS * scaled.effect.announced["order"], "unit": "1/rad"}
    if id == "torque_ripple":
        parameters["order"] = {"value": announced["w"], "unit": "1/rad"}
    if id == "flexible_mode":
        parameters["f"] = {"value": scaled.effect.announced["frequency"], "unit": "Hz"}
    return parameters
