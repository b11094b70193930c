"""A case from a seed: what is hidden and where, how wrong the model is, what is moved.

Cases come in rounds of 206 seeds, shuffled: 40 with nothing hidden, every effect at 0.3, 1 and
3 % of torque RMS on one axis and on several (126), 16 outside any list, 16 pairs at 2 %,
8 changed parameters.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from studies.generator.drives import DRIVES
from studies.generator.effects import TORQUES
from studies.generator.outside import OUTSIDE
from studies.generator.trajectories import KINDS
from tests.oracles.calculus import Array
from tests.oracles.machine import Actuator, Body, Machine, read_machine

INSIDE = (*TORQUES, *DRIVES)
"""Effects that a library may be asked to name, twenty-one of them."""
SIZES = (0.003, 0.01, 0.03)
CHANGES = ("payload", "stiffness", "offset", "damping")
ROUND = 206


@dataclass(frozen=True)
class Hidden:
    """An effect: its identifier, joints (0 to 5), wanted share of torque RMS there, seed."""

    id: str
    axes: tuple[int, ...]
    size: float
    seed: int


@dataclass(frozen=True)
class Change:
    """A parameter of the model that has another value: name, as in the machine file."""

    kind: str
    parameter: str
    before: float
    after: float
    unit: str


@dataclass(frozen=True)
class Noise:
    """Reading: white [N m] RMS; disturbance that moves the arm: coloured RMS, corner [Hz]."""

    white: float
    coloured: float
    corner: float
    seed: int


@dataclass(frozen=True)
class Log:
    """How it is logged: delay of both torque channels [samples] beside the half sample of the
    hold, share of samples dropped, steps of encoder [rad] and torque [N m]."""

    delay: float
    dropped: float = 0.0
    angle_step: float = 1e-8
    torque_step: float = 3e-3


@dataclass(frozen=True)
class Case:
    """All that is drawn. `category`: nothing, single, outside, pair, changed or machine."""

    seed: int
    category: str
    hidden: tuple[Hidden, ...]
    changes: tuple[Change, ...]
    nominal: Machine
    truth: Machine
    noise: Noise
    log: Log
    trajectories: tuple[tuple[str, int], ...]
    """Kind and seed; all but the last for the diagnosis, the last one held out."""
    seconds: float = 12.0
    passes: int = 2
    closed: bool = False


def slots() -> list[tuple[str, str, float, bool]]:
    """A round: category, identifier, size, on several joints; in the order of its seeds."""
    listed = [("nothing", "", 0.0, False)] * 40
    listed += [("single", id, s, many) for id in INSIDE for s in SIZES for many in (False, True)]
    listed += [("outside", id, s, False) for id in OUTSIDE for s in (0.01, 0.03)]
    listed += [("pair", "", 0.02, False)] * 16
    listed += [("changed", kind, 0.0, False) for kind in CHANGES for _ in range(2)]
    order = np.random.default_rng(20).permutation(ROUND)
    return [listed[k] for k in order]


def draw(seed: int, seconds: float = 12.0, closed: bool = False) -> Case:
    """The case of a seed, always the same."""
    rng = np.random.default_rng([seed, 1])
    category, id, size, many = slots()[seed % ROUND]
    hidden: tuple[Hidden, ...] = ()
    if category in ("single", "outside"):
        hidden = (place(rng, id, size, int(rng.integers(2, 5)) if many else 1),)
    elif category == "pair":
        names = rng.choice(INSIDE, 2, replace=False)
        hidden = tuple(place(rng, str(name), size, 1) for name in names)
    return assemble(seed, category, hidden, seconds, closed, id if category == "changed" else "")


def place(rng: np.random.Generator, id: str, size: float, count: int) -> Hidden:
    """An effect on `count` joints drawn at random."""
    axes = tuple(sorted(int(k) for k in rng.choice(6, count, replace=False)))
    return Hidden(id, tuple(range(6)) if id == "gravity_tilt" else axes, size, _seed(rng))


def assemble(
    seed: int,
    category: str,
    hidden: tuple[Hidden, ...],
    seconds: float = 12.0,
    closed: bool = False,
    change: str = "",
) -> Case:
    """Draw the rest: machine, noise, trajectories."""
    rng = np.random.default_rng([seed, 2])
    nominal = read_machine()
    truth = wrong(nominal, rng)
    changes: tuple[Change, ...] = ()
    if change:
        truth, changes = changed(truth, nominal, change, rng)
    colour = 10 ** rng.uniform(-0.3, 1.4)
    noise = Noise(rng.uniform(4e-3, 1.2e-2), rng.uniform(2e-3, 8e-3), colour, _seed(rng))
    dropped = float(rng.choice([0.0, 0.0, 0.0, 1e-3]))
    log = Log(rng.uniform(0.0, 2.0), dropped)
    kinds = ["setpoints", str(rng.choice([k for k in KINDS if k != "setpoints"]))]
    kinds.append(str(rng.choice(["setpoints", "multisine"])))
    moves = tuple((kind, _seed(rng)) for kind in kinds)
    return Case(
        seed, category, hidden, changes, nominal, truth, noise, log, moves, seconds, closed=closed
    )


def wrong(machine: Machine, rng: np.random.Generator) -> Machine:
    """The real machine: inertia about 1 % off the file, stiffness 3, actuators 5, Dahl to 15."""

    def off(value: Array | float, share: float) -> Array:
        return np.asarray(value * (1 + share * rng.standard_normal(np.shape(value))))

    def body(b: Body) -> Body:
        moment = off(np.ones((3, 3)), 0.01)
        return Body(float(off(b.m, 0.01)), off(b.c, 0.01), b.Ic * (moment + moment.T) / 2)

    act = machine.actuator
    terms = {name: off(getattr(act, name), 0.05) for name in "okdcab"}
    sigma = act.sigma * (1 + rng.uniform(-0.15, 0.15))
    return replace(
        machine,
        upper=body(machine.upper),
        lower=body(machine.lower),
        end_effector=body(machine.end_effector),
        J_rotor=off(np.full(6, machine.J_rotor), 0.05),
        k_u=off(machine.k_u, 0.03),
        k_s=off(machine.k_s, 0.03),
        actuator=Actuator(**terms, sigma=sigma, omega=act.omega),
    )


def changed(
    truth: Machine, nominal: Machine, kind: str, rng: np.random.Generator
) -> tuple[Machine, tuple[Change, ...]]:
    """The real machine with one parameter far from the file."""
    act, axis = truth.actuator, int(rng.integers(6))
    if kind == "payload":
        loaded, m = truth.with_payload(0.5), nominal.end_effector.m
        return loaded, (Change(kind, "end_effector.m", m, loaded.end_effector.m, "kg"),)
    if kind == "stiffness":
        stiff = replace(truth, k_u=truth.k_u * 1.25, k_s=truth.k_s * 1.25)
        pairs = zip((*nominal.k_u, *nominal.k_s), (*stiff.k_u, *stiff.k_s), strict=True)
        names = [f"flexures.{n}[{k}]" for n in ("k_u", "k_s") for k in (1, 2)]
        rows = zip(names, pairs, strict=True)
        return stiff, tuple(Change(kind, n, float(a), float(b), "N m/rad") for n, (a, b) in rows)
    name, unit = ("o", "N m") if kind == "offset" else ("d", "N m s/rad")
    values = getattr(act, name).copy()
    values[axis] = values[axis] + rng.choice([-0.3, 0.3]) if name == "o" else values[axis] * 5
    before = float(getattr(nominal.actuator, name)[axis])
    change = Change(kind, f"actuator[{axis + 1}].{name}", before, float(values[axis]), unit)
    return replace(truth, actuator=replace(act, **{name: values})), (change,)


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**31))
