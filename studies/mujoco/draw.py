"""A case from a seed: machine, loop, motions, noise, and what is hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from studies.mujoco import hexapod, inside, machines, motion, outside
from studies.mujoco.case import Case, Loop, Noise, Wanted
from studies.mujoco.machine import Machine, mistaken

Rng = np.random.Generator
FIRST_TEST = 10_000
"""Seeds from here on are for tests; each is used by one version only."""
SHARES = {
    "nothing": 0.18,
    "single": 0.44,
    "pair": 0.10,
    "outside": 0.13,
    "changed": 0.05,
    "payload": 0.04,
    "plain": 0.06,
}
MOST_STEPS = 120_000
"""Simulated instants of a case, about."""
FINEST = 2000
"""Simulated instants in a period of the slowest motion, at least."""
ALONE = {"gravity_tilt", "cross_coupling"}
"""Not in pairs."""
OPEN_CHAIN = ("flexible_mode", "backlash", "noncollocated_mode", "encoder_eccentricity")
"""Not in closed chains: bodies of their own, and readings that do not close."""


SPRINGS = ("torque_offset", "linear_stiffness")
"""In every base model but the arms'."""


def draw(seed: int, category: str | None = None, kind: str | None = None, attempt: int = 0) -> Case:
    """The case of a seed, always the same. ValueError for an unknown category or kind."""
    if category is not None and category not in SHARES:
        raise ValueError(f"category {category!r}: one of {', '.join(SHARES)}")
    if kind is not None and kind not in machines.KINDS:
        raise ValueError(f"kind {kind!r}: one of {', '.join(machines.KINDS)}")
    rng = np.random.default_rng([seed, attempt, 1])
    drawn = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    category = category or drawn
    kinds = {"plain": ["axis", "gantry"], "changed": ["arm"]}.get(category, list(machines.KINDS))
    chosen = str(rng.choice(kinds))
    machine = machines.KINDS[kind or chosen](rng)
    mass = float(10 ** rng.uniform(-2, -1))
    geometry = float(10 ** rng.uniform(np.log10(0.001), np.log10(0.005)))
    if machine.chain is None:
        written = mistaken(machine, mass, geometry, rng)
    else:
        chain = hexapod.mistaken(machine.chain, mass, geometry, rng)
        written = replace(machine, chain=chain)
    case = _runs(rng, seed, category, machine, written)
    if machine.chain is not None:
        # its feedforward needs the closure, which only the simulation solves
        case = replace(case, loop=replace(case.loop, feedforward="none"))
    case = replace(case, mass_error=mass, geometry_error=geometry)
    return _hide(rng, case)


def _runs(rng: Rng, seed: int, category: str, machine: Machine, written: Machine) -> Case:
    count = int(rng.choice([1, 2, 3, 4], p=[0.08, 0.22, 0.4, 0.3]))
    passes = int(rng.choice([1, 2, 3, 4], p=[0.1, 0.45, 0.3, 0.15]))
    if category == "payload":
        passes = 2 * int(rng.integers(1, 3))
    seconds = max(float(rng.uniform(3.0, 10.0)), 1.8 / machine.frequency)
    fastest = max(MOST_STEPS / (count * passes * seconds), 200.0)
    rate = float(round(min(10 ** rng.uniform(np.log10(60), 4), fastest)))
    if rate == round(fastest):
        # fast logs are short where the machine is quick enough
        seconds = max(3.0, 1.8 / machine.frequency)
        rate = float(round(min(1e4, MOST_STEPS / (count * passes * seconds))))
    finest = float(np.clip(FINEST * machine.frequency, 250, 2000))
    substeps = max(1, int(np.ceil(finest / rate)))
    kinds = [str(rng.choice(motion.KINDS)) for _ in range(count)]
    encoder = min(float(10 ** rng.uniform(-8, -3)), 1e-3 * min(machine.reach))
    noise = Noise(
        float(10 ** rng.uniform(-3, -1.7)),
        float(10 ** rng.uniform(-3.5, -2)),
        float(10 ** rng.uniform(-3.5, -2)),
        float(10 ** rng.uniform(-3, -1.7)),
        float(10 ** rng.uniform(-0.3, 1.4)),
        float(10 ** rng.uniform(1, 2.3)),
        float(10 ** rng.uniform(-4, -2)),
        int(rng.integers(2**31)),
    )
    stiff = bool(rng.random() < 0.5)
    loop = Loop(
        float(rng.uniform(15, 40) if stiff else rng.uniform(5, 12)),
        bool(rng.random() < 0.5),
        str(rng.choice(["none", "gravity", "full"], p=[0.4, 0.2, 0.4])),
    )
    plain = category == "plain"
    return Case(
        seed,
        category,
        machine,
        written,
        0.0,
        0.0,
        rate,
        substeps,
        seconds,
        tuple((kind, int(rng.integers(2**31))) for kind in kinds),
        passes,
        loop,
        noise,
        encoder,
        0 if plain or rng.random() < 0.5 else int(rng.integers(1, 6)),
        bool(rng.random() < 0.7),
        bool(rng.random() < 0.5),
        bool(rng.random() < 0.5),
        "csv" if rng.random() < 0.25 else "h5",
    )


def _hide(rng: Rng, case: Case) -> Case:
    machine = case.machine
    if case.category == "single":
        return replace(case, hidden=(_wanted(rng, machine, _ids(machine)),))
    if case.category == "outside":
        return replace(case, hidden=(_wanted(rng, machine, _outside(machine)),))
    if case.category == "pair":
        names = [id for id in _ids(machine) if id not in ALONE]
        one, two = (str(id) for id in rng.choice(names, 2, replace=False))
        return replace(case, hidden=(_wanted(rng, machine, [one]), _wanted(rng, machine, [two])))
    if case.category == "plain":
        names = ["coulomb_friction", "cogging_harmonic", "viscous_friction"]
        every = tuple(range(machine.n))
        size = [float(10 ** rng.uniform(-1.5, -0.5)) for _ in names]
        hidden = [Wanted(id, every, s, _seed(rng)) for id, s in zip(names, size, strict=True)]
        return replace(case, hidden=tuple(hidden))
    if case.category == "payload":
        last = machine.links[-1].mass if machine.links else machine.chain.platform.m
        mass, announced = float(last * rng.uniform(0.1, 0.6)), bool(rng.random() < 0.5)
        return replace(case, payload=mass, announced=announced)
    if case.category == "changed":
        return _changed(rng, case)
    return case


def _ids(machine: Machine) -> list[str]:
    """Effects of the library that a machine can have and its base model does not."""
    left = set[str]()
    if machine.chain is not None:
        left |= set(OPEN_CHAIN) | {"viscous_friction", *SPRINGS}
    elif machine.kind != "arm":
        # their base model has a viscous term, and free gravity and inertia
        left |= {"viscous_friction", "gravity_tilt", "drive_gain", *SPRINGS}
    if machine.units[0] != "rad":
        left |= {"encoder_eccentricity"}
    if machine.n == 1:
        left |= {"cross_coupling"}
    return [id for id in inside.MAKERS if id not in left]


def _outside(machine: Machine) -> list[str]:
    left = OPEN_CHAIN if machine.chain is not None else ()
    return [id for id in outside.MAKERS if id not in left]


def _wanted(rng: Rng, machine: Machine, ids: list[str]) -> Wanted:
    id, n = str(rng.choice(ids)), machine.n
    count = min(n, int(rng.choice([1, 1, 2, 3])))
    if id == "cross_coupling":
        count = 1
    axes = tuple(sorted(int(k) for k in rng.choice(n, count, replace=False)))
    size = float(10 ** rng.uniform(-2.5, -0.9))
    return Wanted(id, axes, size, _seed(rng))


def _changed(rng: Rng, case: Case) -> Case:
    """A mass or rotor far from the file, the real machine's."""
    k, machine = int(rng.integers(case.machine.n)), case.machine
    link, factor = machine.links[k], float(rng.choice([0.6, 1.4, 1.7]))
    kind = str(rng.choice(["mass", "armature"]))
    before = getattr(link, kind)
    links = list(machine.links)
    links[k] = replace(link, **{kind: before * factor})
    change: dict[str, object] = {
        "kind": kind,
        "axis": k + 1,
        "parameter": f"link[{k + 1}].{kind}",
        "accept": [f"link[{k + 1}]."] if kind == "mass" else [f"J_r[{k + 1}]", f"link[{k + 1}].J"],
        "before": before,
        "after": before * factor,
    }
    return replace(case, machine=replace(machine, links=tuple(links)), changes=(change,))


def _seed(rng: Rng) -> int:
    return int(rng.integers(2**31))
