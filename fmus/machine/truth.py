"""Ground truth of `machine.fmu`: the nominal plant plus deviations that its model lacks.

Reads `machines/*-truth.toml`. Nothing but the build of machine.fmu may read it; its
effects are written independently of the library of effects.
"""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.interface import Interface, Variable, parameter
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.quantity import quantity
from flexhex.fmus.common.machine_file import read_toml
from flexhex.fmus.plant import equations
from flexhex.fmus.plant import interface as nominal


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Errors(_Section):
    """Relative standard deviations by which each body and joint differs from the file."""

    inertia: Annotated[float, quantity("1", ge=0, le=0.5)]
    stiffness: Annotated[float, quantity("1", ge=0, le=0.5)]
    actuator: Annotated[float, quantity("1", ge=0, le=0.5)]


class Cogging(_Section):
    """Harmonics of omega_cog that the model does not have; rms [N m] of their sum."""

    orders: tuple[Annotated[float, Field(gt=0, le=200)], ...]
    rms: Annotated[float, quantity("N m", ge=0)]


class Noise(_Section):
    """White noise a base step [N m]: on the motor torque, and on its reading."""

    torque: Annotated[float, quantity("N m", ge=0)]
    reading: Annotated[float, quantity("N m", ge=0)]


class Drift(_Section):
    """What creeps in as the machine warms up: offset torque (rms over the joints), relative
    loss of the motor constant, time constant."""

    torque: Annotated[float, quantity("N m", ge=0)]
    gain: Annotated[float, quantity("1", ge=0, le=0.5)]
    time: Annotated[float, quantity("s", gt=0)]


KINDS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "lugre": (("F_c", "N m"), ("F_s", "N m"), ("v_s", "rad/s"), ("sigma_0", "N m/rad")),
    "cubic": (("k", "N m/rad3"),),
    "cable": (("k", "N m/rad"), ("begin", "rad"), ("side", "1")),
    "saturation": (("level", "N m"),),
    "harmonic": (("size", "N m"), ("order", "1/rad"), ("phase", "rad")),
    "drag": (("d", "N m s2/rad2"),),
    "ripple": (("size", "1"), ("order", "1/rad"), ("phase", "rad")),
    "bump": (("height", "N m"), ("at", "rad"), ("width", "rad")),
    "inertia": (("size", "kg m2"), ("order", "1/rad"), ("phase", "rad")),
}
"""Hidden effects and their values, in the order of `hidden_kind` in hidden_effects.h."""
WIDTH = 6
"""HIDDEN_WIDTH there: kind, axis, values."""
_DIVISORS = {"F_c", "F_s", "v_s", "sigma_0", "level", "width"}


class Hidden(_Section):
    """An effect that hidden_effects.h computes: kind, axes from 1, values by name."""

    kind: str
    axes: Annotated[tuple[Annotated[int, Field(ge=1, le=6)], ...], Field(min_length=1)]
    values: Mapping[str, float]

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        known = KINDS.get(data.get("kind", "")) if isinstance(data, dict) else None
        if known is None:
            raise ValueError(f"kind must be one of {', '.join(KINDS)}")
        tables = data.get("values", {})
        if sorted(tables) != sorted(name for name, _ in known):
            raise ValueError(f"{data['kind']} has the values {', '.join(n for n, _ in known)}")
        read = {}
        for name, unit in known:
            limit = 0.0 if name in _DIVISORS else None
            read[name] = quantity(unit, gt=limit).func(tables[name])  # type: ignore[call-arg]
        return {**data, "values": read}

    def rows(self) -> list[float]:
        """Numbers for hidden_effects.h, axis by axis."""
        given = [self.values[name] for name, _ in KINDS[self.kind]]
        kind = float(list(KINDS).index(self.kind))
        numbers = []
        for axis in self.axes:
            # unused widths are 1: the C divides by them for every kind
            numbers += [kind, axis - 1.0, *given, *[1.0] * (WIDTH - 2 - len(given))]
        return numbers


class Truth(_Section):
    """Deviations of the machine from its model, drawn from `seed`."""

    seed: Annotated[int, Field(ge=0, lt=2**53)]
    errors: Errors
    cogging: Cogging
    noise: Noise
    drift: Drift
    hidden: tuple[Hidden, ...] = ()


def load_truth(path: str | Path) -> Truth:
    """Read and check a truth file; MachineError names file and field."""
    try:
        return Truth.model_validate(read_toml(path))
    except ValidationError as error:
        raise MachineError("\n".join(complaints(path, Truth, error.errors()))) from None


def interface(machine: Machine, truth: Truth) -> Interface:
    """`machine`: the plant's interface with the truth in its parameters' start values."""
    base, n = _nominal(machine), machine.n_arms
    known = {v.name: v for v in base.variables}
    altered = {
        "mechanism": _mechanism(known["mechanism"], truth),
        "actuator": _actuator(known["actuator"].starts, truth),
    }
    variables = [
        dataclasses.replace(v, start=altered[v.name]) if v.name in altered else v
        for v in base.variables
    ]
    added, rows = _deviations(truth, n), [number for e in truth.hidden for number in e.rows()]
    constants = {**base.constants, "HIDDEN": 1}
    if rows:
        text = "hidden effects, a row each: kind, axis, numbers"
        added.append(parameter("hidden_effects", "1", text, rows, -1e12, 1e12, size=len(rows)))
        constants["N_HIDDEN"] = len(rows) // WIDTH
    text = (
        "Ground truth for tests: the plant with deviations from its model. Without a controller it"
        " falls onto its end stops: the torque that tau starts at holds the model"
    )
    return Interface("machine", text, base.Ts, (*variables, *added), constants, base.faults)


@lru_cache(maxsize=8)
def _nominal(machine: Machine) -> Interface:
    """The plant's interface, once for all truths that a study draws."""
    return nominal.interface(machine)


def _deviations(truth: Truth, n: int) -> list[Variable]:
    """Parameters that the plant lacks; ranges are wide, but all torques stay finite in them."""
    cogging, draw = _cogging(truth, n), _draw(truth, "drift")
    creep = [truth.drift.torque * draw.gauss(0, 1) for _ in range(n)]
    drift, noise, size = truth.drift, truth.noise, len(cogging)
    lacking = "cogging that the model lacks: cos, sin of each order"
    offset, loss = (
        f"drift: {what} after a long time"
        for what in ("torque offset", "loss of the motor constant")
    )
    white = "standard deviation, white each base step"
    return [
        parameter("hidden_cogging", "N m", lacking, cogging, -1e4, 1e4, size=size),
        parameter("drift_torque", "N m", offset, creep, -1e4, 1e4, size=n),
        parameter("drift_gain", "1", loss, drift.gain, 0, 1e4),
        parameter("drift_time", "s", "drift: time constant", drift.time, 1e-6, 1e12),
        parameter("age", "s", "drift: time since switch-on", 0, 0, 1e12),
        parameter(
            "noise_torque", "N m", f"noise of the motor torque: {white}", noise.torque, 0, 1e4
        ),
        parameter(
            "noise_reading", "N m", f"noise of the torque reading: {white}", noise.reading, 0, 1e4
        ),
        parameter("seed", "1", "seed of the noise, whole", truth.seed, 0, 2**53),
    ]


def functions(machine: Machine, truth: Truth) -> list[ca.Function]:
    """The plant's functions and the torque (6,) that the model does not know:
    plant_hidden(theta, tau_motor, age, cogging, drift, gain, time)."""
    n, orders = machine.n_arms, truth.cogging.orders
    theta, tau_motor = ca.SX.sym("theta", n), ca.SX.sym("tau_motor", n)
    age, gain, time = ca.SX.sym("age"), ca.SX.sym("gain"), ca.SX.sym("time")
    cogging, drift = ca.SX.sym("cogging", 2 * n * len(orders)), ca.SX.sym("drift", n)
    torque = (drift + gain * tau_motor) * (1 - ca.exp(-age / time))
    for i in range(n):
        for k, order in enumerate(orders):
            angle, at = order * machine.actuator.omega_cog * theta[i], 2 * (len(orders) * i + k)
            torque[i] += cogging[at] * ca.cos(angle) + cogging[at + 1] * ca.sin(angle)
    hidden = ca.Function(
        "plant_hidden",
        [theta, tau_motor, age, cogging, drift, gain, time],
        [torque],
        ["theta", "tau_motor", "age", "cogging", "drift", "gain", "time"],
        ["torque"],
    )
    return [*equations.functions(machine), hidden]


def _draw(truth: Truth, what: str) -> random.Random:
    """Random numbers of one quantity, independent of the other draws."""
    return random.Random(f"{truth.seed}:{what}")


def _actuator(values: Sequence[float], truth: Truth) -> list[float]:
    draw = _draw(truth, "actuator")
    return [value * (1 + truth.errors.actuator * draw.gauss(0, 1)) for value in values]


def _mechanism(variable: Variable, truth: Truth) -> list[float]:
    """Bodies keep their shape: one factor for all inertias of a body, stiffness each its own."""
    changed = []
    for name, value in zip(variable.elements, variable.starts, strict=True):
        flexure = name.startswith("flexure")
        sigma = truth.errors.stiffness if flexure else truth.errors.inertia
        draw = _draw(truth, name if flexure else name.split(".")[0])
        changed.append(value * (1 + sigma * draw.gauss(0, 1)))
    return changed


def _cogging(truth: Truth, n: int) -> NDArray[np.float64]:
    """cos, sin amplitudes by joint and order, scaled to the wanted rms for each joint."""
    count, draw = len(truth.cogging.orders), _draw(truth, "cogging")
    raw = np.array([draw.gauss(0, 1) for _ in range(2 * n * count)]).reshape(n, 2 * count)
    rms = np.sqrt((raw**2).sum(axis=1, keepdims=True) / 2) if count else 1.0
    return np.asarray((truth.cogging.rms * raw / rms).ravel())
