"""`simulate`: the runs of a case, with the effects as they were sized."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from studies.mujoco import hexapod, inside, outside
from studies.mujoco.case import Case, Loop
from studies.mujoco.draw import draw
from studies.mujoco.effect import Effect, Motion
from studies.mujoco.logger import heavy
from studies.mujoco.machine import Array, Machine, loaded, triple
from studies.mujoco.model import compiled
from studies.mujoco.place import Place
from studies.mujoco.simulate import Plant, Record, UnstableLoopError, gains_of, run

ATTEMPTS = 12


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
    machines = [case.machine, heavier_machine(case)]
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


def heavier_machine(case: Case) -> Machine:
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
