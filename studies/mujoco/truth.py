"""`truth_of`: what a case hides, and how much of it can be seen."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from studies.mujoco.case import Case
from studies.mujoco.effect import Late
from studies.mujoco.machine import Array
from studies.mujoco.model import compiled, inverse
from studies.mujoco.observable import changed, contribution, observable
from studies.mujoco.runs import Simulated, heavier_machine
from studies.mujoco.simulate import Record

FAMILY = "mujoco"


def truth_of(simulated: Simulated) -> dict[str, Any]:
    """The truth as JSON; axes count from 1."""
    case = simulated.case
    count = len(simulated.records)
    fitted = [passes[0] for passes in (simulated.records[:-1] if count > 1 else simulated.records)]
    rms = np.sqrt(np.mean(np.concatenate([r.u for r in fitted]) ** 2, axis=0))
    rows = [_effect_row(simulated, k, fitted, rms) for k in range(len(simulated.effects))]
    # damping is a parameter of all base models but the arm's, and no effect to be named
    alone = rows if case.category == "outside" else []
    own = set[str]() if case.machine.kind == "arm" else {"viscous_friction"}
    return {
        "family": FAMILY,
        "seed": case.seed,
        "machine": case.machine.kind,
        "axes": case.machine.n,
        "category": "single" if alone and alone[0]["inside"] else case.category,
        "hidden": [row for row in rows if row["id"] not in own],
        "beside": [row for row in rows if row["id"] in own],
        "changed": [*_changes(case, fitted), *_payload(case, fitted, rms)],
        "torque_rms": rms.tolist(),
        "units": list(case.machine.units),
        "mass_error": case.mass_error,
        "geometry_error": case.geometry_error,
        "noise": asdict(case.noise),
        "loop": asdict(case.loop),
        "rate": case.rate,
        "seconds": case.seconds,
        "delay_cycles": case.delay,
        "encoder": case.encoder,
        "aligned": case.aligned,
        "trajectories": [kind for kind, _ in case.trajectories],
        "passes": case.passes,
        "channels": ["theta", "tau_meas", *(["tau"] * case.command), *(["r"] * case.reference)],
        "payload": {"mass": case.payload, "announced": case.announced},
        "tracking_rms": [float(np.sqrt(np.mean((r.q[:, r.at] - r.r) ** 2))) for r in fitted],
    }


def _effect_row(simulated: Simulated, k: int, fitted: list[Record], rms: Array) -> dict[str, Any]:
    """One effect: names and axes that are right, true parameters, size and what can be seen."""
    case, effect = simulated.case, simulated.effects[k]
    contributions = [contribution(case, simulated.effects, k, record) for record in fitted]
    own = np.sqrt(np.mean(np.concatenate(contributions) ** 2, axis=0))
    late = [other.seconds for other in simulated.effects if isinstance(other, Late)]
    free = observable(case, contributions, fitted, delays=late)
    rubbed = observable(case, contributions, fitted, friction=True, delays=late)
    axes = list(effect.axes)
    whole = float(np.linalg.norm(rms[axes]))
    return {
        "id": effect.id,
        "accept": list(effect.accept),
        "inside": bool(effect.accept),
        "axes": [k + 1 for k in axes],
        "wanted": case.hidden[k].size if case.hidden else 0.0,
        "size": float(np.linalg.norm(own[axes])) / whole,
        "observable": float(np.linalg.norm(free[axes])) / whole,
        "observable_beside_friction": float(np.linalg.norm(rubbed[axes])) / whole,
        "observable_per_axis": (free / np.maximum(rms, 1e-300)).tolist(),
        "parameters": effect.parameters(case.step),
    }


def _changes(case: Case, fitted: list[Record]) -> list[dict[str, Any]]:
    """Changes with what can be seen of them."""
    rows = []
    for change in case.changes:
        k, kind = change["axis"] - 1, change["kind"]
        links, was = list(case.machine.links), {kind: change["before"]}
        links[k] = replace(links[k], **was)
        before = replace(case.machine, links=tuple(links))
        models = (compiled(m, case.step, ()) for m in (case.machine, before))
        now, then = ([inverse(m, r.q, r.v, r.a)[:, r.at] for r in fitted] for m in models)
        differences = [a - b for a, b in zip(now, then, strict=True)]
        body = rf"body\[{k + 1}\]\."
        own = body if kind == "mass" else rf"rotor\[{k + 1}\]|{body}I"
        rows.append({**change, "observable": changed(case, differences, fitted, own)})
    return rows


def _payload(case: Case, fitted: list[Record], rms: Array) -> list[dict[str, Any]]:
    if case.payload == 0:
        return []
    bare, heavier = (compiled(m, case.step, ()) for m in (case.machine, heavier_machine(case)))
    thin = [replace(r, q=r.q[::7], v=r.v[::7], a=r.a[::7]) for r in fitted]
    contributions = [
        (inverse(heavier, r.q, r.v, r.a) - inverse(bare, r.q, r.v, r.a))[:, r.at] for r in thin
    ]
    own = np.sqrt(np.mean(np.concatenate(contributions) ** 2, axis=0))
    last = case.machine.n
    return [
        {
            "kind": "payload",
            "parameter": "payload",
            "accept": ["payload", f"link[{last}].", "end_effector"],
            "before": 0.0,
            "after": case.payload,
            "announced": case.announced,
            "size": float(np.linalg.norm(own) / np.linalg.norm(rms)),
        }
    ]
