"""Logs, machine file and sealed truth of plain axes."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from studies.axes import PASSES, SETTLE, TRAJECTORIES, Array, Case, Run, cogging, runs_of


@dataclass(frozen=True)
class Written:
    """Files of a case."""

    paths: tuple[Path, ...]
    test_paths: tuple[Path, ...]
    machine_file: Path
    sealed: Path


def write(case: Case, logs: Path, sealed: Path) -> Written:
    """Logs and machine file into `logs`, the truth into `sealed`: folders apart."""
    runs = runs_of(case)
    logs.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    scale = np.std(runs[0][0].u, axis=0)
    fit, tests = list[Path](), list[Path]()
    rng = np.random.default_rng([case.seed, 37])
    for letter, passes in enumerate(runs):
        for k, run in enumerate(passes):
            path = logs / f"run{PASSES * letter + k + 1:02d}.h5"
            _log(case, run, scale, {"trajectory": "abc"[letter], "pass": str(k + 1)}, path, rng)
            (tests if letter == TRAJECTORIES - 1 else fit).append(path)
    machine = logs / "machine.toml"
    machine.write_text('kind = "axis"\n', encoding="utf-8")
    truth = sealed / f"axes-{case.seed}.json"
    truth.write_text(json.dumps(truth_of(case, runs), indent=1) + "\n", encoding="utf-8")
    return Written(tuple(fit), tuple(tests), machine, truth)


def _log(
    case: Case, run: Run, scale: Array, meta: dict[str, str], path: Path, rng: np.random.Generator
) -> None:
    first = round(SETTLE * case.seconds * case.rate)
    q, u = run.q[first:], run.u[first:]
    noise = case.noise * scale * rng.standard_normal(u.shape)
    with h5py.File(path, "w") as file:
        for name, text in meta.items():
            file.attrs[name] = text
        channels = {
            "time": (np.arange(len(q)) / case.rate, "s"),
            "theta": (np.round(q / case.encoder) * case.encoder, "rad"),
            "tau_meas": (u + noise, "N m"),
        }
        for name, (values, unit) in channels.items():
            file.create_dataset(name, data=values).attrs["unit"] = unit


def truth_of(case: Case, runs: list[list[Run]]) -> dict[str, Any]:
    """The truth as JSON, as studies/mujoco/README.md says; axes count from 1."""
    fitted = [passes[0] for passes in runs[:-1]]
    rms = np.sqrt(np.mean(np.concatenate([r.u for r in fitted]) ** 2, axis=0))
    friction = [r.z * case.friction for r in fitted]
    waves = [cogging(case, r.q) for r in fitted]
    count = len(case.heights)
    turning = {
        "order": {"value": [float(case.order)] * case.n, "unit": "1/rad"},
        "harmonics": {"value": case.heights.tolist(), "unit": "1"},
    }
    return {
        "family": "axes",
        "seed": case.seed,
        "machine": "axis",
        "axes": case.n,
        "category": "plain",
        "hidden": [
            _row("coulomb_friction", friction, fitted, rms)
            | {"parameters": {"F_c": {"value": case.friction.tolist(), "unit": "N m"}}},
            _row("cogging_harmonic", waves, fitted, rms) | {"parameters": turning},
        ],
        "changed": [],
        "torque_rms": rms.tolist(),
        "trajectories": ["waves"] * TRAJECTORIES,
        "passes": PASSES,
        "harmonics": count,
        "drawn": {
            k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(case).items()
        },
    }


def _row(id: str, parts: list[Array], fitted: list[Run], rms: Array) -> dict[str, Any]:
    """One effect; observable: what inertia, damping, spring, gravity and offset leave of it."""
    own, free = np.concatenate(parts), np.zeros(len(rms))
    for i in range(len(rms)):
        q, v, a = (np.concatenate([getattr(r, x)[:, i] for r in fitted]) for x in ("q", "v", "a"))
        columns = np.stack([np.ones_like(q), a, v, q, np.sin(q), np.cos(q)], axis=1)
        columns /= np.linalg.norm(columns, axis=0)
        left = own[:, i] - columns @ np.linalg.lstsq(columns, own[:, i], rcond=1e-9)[0]
        free[i] = np.sqrt(np.mean(left**2))
    whole = float(np.linalg.norm(rms))
    return {
        "id": id,
        "accept": [id],
        "inside": True,
        "axes": list(range(1, len(rms) + 1)),
        "size": float(np.linalg.norm(np.sqrt(np.mean(own**2, axis=0)))) / whole,
        "observable": float(np.linalg.norm(free)) / whole,
        "observable_per_axis": (free / rms).tolist(),
    }
