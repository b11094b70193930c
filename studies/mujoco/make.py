"""`make`: a case's logs, machine file and sealed truth."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from studies.mujoco import hexapod, inside, outside
from studies.mujoco.case import Case, Loop
from studies.mujoco.draw import FIRST_TEST, draw
from studies.mujoco.effect import Effect, Motion
from studies.mujoco.logger import heavy, logged, write
from studies.mujoco.machine import Array, Machine, loaded, toml, triple
from studies.mujoco.model import compiled, inverse
from studies.mujoco.observable import changed, contribution, observable
from studies.mujoco.place import Place
from studies.mujoco.simulate import Plant, Record, UnstableLoopError, gains_of, run

FAMILY = "mujoco"
ATTEMPTS = 12
OUTSIDE = frozenset(outside.MAKERS)


@dataclass(frozen=True)
class Written:
    """Files of a case: logs to fit, logs of a trajectory for tests, machine file, sealed truth."""

    paths: tuple[Path, ...]
    test_paths: tuple[Path, ...]
    machine_file: Path
    sealed: Path


@dataclass(frozen=True)
class Simulated:
    """A case with its effects as they were sized, its runs [trajectory][pass], torque RMS (n,)."""

    case: Case
    effects: tuple[Effect, ...]
    records: list[list[Record]]
    scale: Array


def simulate(
    seed: int, category: str | None = None, kind: str | None = None, effect: str | None = None
) -> Simulated:
    """A seed's runs. A loop that runs away is drawn again. `effect` replaces the ids drawn."""
    trouble = ""
    for attempt in range(ATTEMPTS):
        case = draw(seed, category, kind, attempt)
        if effect is not None:
            case = replace(case, hidden=tuple(replace(h, id=effect) for h in case.hidden))
        if any(h.id == "noncollocated_mode" for h in case.hidden):
            # a spring between motor and encoder stands no more than a slow feedback
            case = replace(case, loop=Loop(1.5, False, "full"))
        try:
            return runs_of(case)
        except UnstableLoopError as error:
            trouble = str(error)
    raise UnstableLoopError(f"none of {ATTEMPTS} machines follows its reference: {trouble}")


def runs_of(case: Case, effects: tuple[Effect, ...] | None = None) -> Simulated:
    """All runs of a case; `effects`: instead of those that it would make."""
    gains, zero = gains_of(case), np.zeros(case.machine.n)
    quiet = Plant(case, compiled(case.machine, case.step, ()), (), gains, zero)
    # a limit is met where the torque is largest, wherever that is
    every = any(wanted.id == "torque_saturation" for wanted in case.hidden)
    firsts = [run(quiet, t, 0) for t in case.trajectories[: None if every else 1]]
    motion = Motion(
        *(np.concatenate([getattr(r, x) for r in firsts]) for x in ("t", "q", "v", "a", "u"))
    )
    scale = np.maximum(motion.rms(), 1e-3 * motion.rms().max())
    if effects is None:
        effects = tuple(_effect(case, k, motion) for k in range(len(case.hidden)))
    machines = [case.machine, _heavier(case)]
    plants = [
        Plant(case, compiled(machine, case.step, effects), effects, gains, scale)
        for machine in machines[: 1 + (case.payload > 0)]
    ]
    records, number = [], 0
    for trajectory in case.trajectories:
        passes = []
        for k in range(case.passes):
            number += 1
            passes.append(run(plants[int(heavy(case, k))], trajectory, number))
        records.append(passes)
    return Simulated(case, effects, records, scale)


def _heavier(case: Case) -> Machine:
    """The machine with its payload, at a place that the machine file does not give."""
    if case.payload == 0:
        return case.machine
    if case.machine.chain is not None:
        return replace(case.machine, chain=hexapod.loaded(case.machine.chain, case.payload))
    rng = np.random.default_rng([case.noise.seed, 17])
    last = case.machine.links[-1]
    reach = max(float(np.linalg.norm(last.centre)), 1e-3)
    at = np.array(last.centre) * 1.5 + 0.2 * reach * rng.standard_normal(3)
    return loaded(case.machine, case.payload, triple(at))


def _effect(case: Case, k: int, motion: Motion) -> Effect:
    wanted = case.hidden[k]
    rng = np.random.default_rng(wanted.seed)
    place = Place(case.machine, wanted.axes, motion, case.rate)
    maker = inside.MAKERS.get(wanted.id) or outside.MAKERS[wanted.id]
    effect = maker(rng, place)
    effect.size(motion, wanted.size)
    return effect


def make(
    seed: int,
    logs: Path,
    sealed: Path,
    *,
    category: str | None = None,
    kind: str | None = None,
    effect: str | None = None,
    test: bool = False,
) -> Written:
    """Write a case: logs and machine file into `logs`, the truth into `sealed`.

    category, kind (of machine), effect (id): instead of those that the seed draws. ValueError for
    a test seed without `test`, and when one folder lies in the other.
    """
    refuse(seed, test)
    one, two = logs.resolve(), sealed.resolve()
    if one == two or one in two.parents or two in one.parents:
        raise ValueError(f"{sealed}: the truth must lie apart from the logs in {logs}")
    simulated = simulate(seed, category, kind, effect)
    case = simulated.case
    logs.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    fit, kept = list[Path](), list[Path]()
    for log in logged(case, simulated.effects, simulated.records, simulated.scale):
        path = logs / f"{log.name}.{case.ending}"
        write(log, path, case.machine.units)
        (kept if log.test else fit).append(path)
    machine_file = logs / "machine.toml"
    chain, reach = case.written.chain, max(case.machine.reach)
    known = case.mass_error, case.geometry_error
    text = toml(case.written, *known) if chain is None else hexapod.toml(chain, reach, *known)
    machine_file.write_text(text)
    truth = sealed / f"{FAMILY}-{seed}.json"
    truth.write_text(json.dumps(truth_of(simulated), indent=1) + "\n", encoding="utf-8")
    return Written(tuple(fit), tuple(kept), machine_file, truth)


def refuse(seed: int, test: bool) -> None:
    """ValueError for a seed below 0, and for a test seed that is not meant."""
    if seed < 0:
        raise ValueError(f"seed {seed}: 0 or more is wanted")
    if seed >= FIRST_TEST and not test:
        raise ValueError(f"seed {seed}: from {FIRST_TEST} on for tests only, say --test")


def truth_of(simulated: Simulated) -> dict[str, Any]:
    """The truth as JSON; axes count from 1."""
    case = simulated.case
    count = len(simulated.records)
    fitted = [passes[0] for passes in (simulated.records[:-1] if count > 1 else simulated.records)]
    rms = np.sqrt(np.mean(np.concatenate([r.u for r in fitted]) ** 2, axis=0))
    rows = [_effect_row(simulated, k, fitted, rms) for k in range(len(simulated.effects))]
    # damping is a parameter of all base models but the arm's, and no effect to be named
    own = set[str]() if case.machine.kind == "arm" else {"viscous_friction"}
    return {
        "family": FAMILY,
        "seed": case.seed,
        "machine": case.machine.kind,
        "axes": case.machine.n,
        "category": case.category,
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
    free = observable(case, contributions, fitted)
    rubbed = observable(case, contributions, fitted, friction=True)
    axes = list(effect.axes)
    whole = float(np.linalg.norm(rms[axes]))
    return {
        "id": effect.id,
        "accept": list(effect.accept),
        "inside": effect.id not in OUTSIDE,
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
    bare, heavier = (compiled(m, case.step, ()) for m in (case.machine, _heavier(case)))
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
