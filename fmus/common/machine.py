"""A machine is data: `machines/*.toml`, read and checked here.

`load_machine("machines/tflex.toml")` gives a frozen `Machine`. What the file says
about units and ranges is checked field by field; that bodies are physical and that
the mechanism closes is checked at the end. Every complaint is a MachineError that
names file, field and remedy.
"""

from __future__ import annotations

import tomllib
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fmus.common.errors import MachineError
from fmus.common.quantity import quantity

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", ignored_types=(cached_property,))


class Gravity(_Section):
    """g (3,) [m/s2] in the world frame, z up."""

    g: Annotated[Vector, quantity("m/s2", 3)]


class Geometry(_Section):
    """L, l: upper and lower arm [m]; x_E0 (3,): neutral position of E [m]; stroke [rad]."""

    L: Annotated[float, quantity("m", gt=0)]
    l: Annotated[float, quantity("m", gt=0)]  # noqa: E741 - the paper's neighbour of L
    x_E0: Annotated[Vector, quantity("m", 3)]
    stroke: Annotated[float, quantity("rad", gt=0, le=1.5)]


class Arm(_Section):
    """One arm in the world frame at the neutral pose; a positive angle turns about `axis`.

    x_B (3,) [m]: point on the motor axis; axis, u_B (3,): unit vectors of the motor axis and
    along the upper arm, at right angles; r_EP (3,) [m]: spherical joint in E.
    """

    x_B: Annotated[Vector, quantity("m", 3)]
    axis: Annotated[Vector, quantity("1", 3)]
    u_B: Annotated[Vector, quantity("1", 3)]
    r_EP: Annotated[Vector, quantity("m", 3)]

    @model_validator(mode="after")
    def _frame(self) -> Arm:
        axis, u = np.array(self.axis), np.array(self.u_B)
        for name, v in (("axis", axis), ("u_B", u)):
            if abs(np.linalg.norm(v) - 1) > 1e-9:
                raise ValueError(f"{name} has length {np.linalg.norm(v):.12g}, must be 1")
        if abs(axis @ u) > 1e-9:
            raise ValueError("u_B is not at right angles to axis")
        return self


class Body(_Section):
    """m [kg], centre of mass c (3,) [m], Ic (6,) [kg m2]: xx, yy, zz, xy, xz, yz about it."""

    m: Annotated[float, quantity("kg", gt=0)]
    c: Annotated[Vector, quantity("m", 3)]
    Ic: Annotated[Vector, quantity("kg m2", 6)]

    @model_validator(mode="after")
    def _physical(self) -> Body:
        principal = np.linalg.eigvalsh(symmetric(self.Ic))
        if principal[0] <= 0:
            raise ValueError(f"Ic is not positive definite (smallest {principal[0]:.3g} kg m2)")
        if principal[2] > principal[0] + principal[1] + 1e-12:
            raise ValueError("Ic breaks the triangle inequality: no body has such moments")
        return self


class UpperArm(Body):
    """Upper arm in B, with the rotor's inertia J_rotor [kg m2] about the motor axis."""

    J_rotor: Annotated[float, quantity("kg m2", ge=0)]


class EndEffector(Body):
    """End-effector in E; a payload is a point mass at c_payload (3,) [m]."""

    c_payload: Annotated[Vector, quantity("m", 3)]


class Bodies(_Section):
    """The three kinds of bodies; all arms are alike."""

    upper: UpperArm
    lower: Body
    end_effector: EndEffector


class Flexures(_Section):
    """Joint stiffness [N m/rad]: k_u (2,) universal bendings, k_s (2,) spherical twist, bending."""

    k_u: Annotated[Vector, quantity("N m/rad", 2, ge=0)]
    k_s: Annotated[Vector, quantity("N m/rad", 2, ge=0)]


class Actuator(_Section):
    """The terms of [SH, Eq. (22)] for each of the actuators; a, b (n_arms, n_harmonics)."""

    sigma: Annotated[float, quantity("rad", gt=0)]
    omega_cog: Annotated[float, quantity("1/rad", gt=0)]
    n_harmonics: Annotated[int, Field(ge=1, le=20)]
    o: Annotated[Vector, quantity("N m", -1)]
    k: Annotated[Vector, quantity("N m/rad", -1)]
    d: Annotated[Vector, quantity("N m s/rad", -1, ge=0)]
    c: Annotated[Vector, quantity("N m", -1, ge=0)]
    a: Annotated[Matrix, quantity("N m", -1, -1)]
    b: Annotated[Matrix, quantity("N m", -1, -1)]


class Drive(_Section):
    """Servo drive: torque constant, limit, quantum, current loop and extra delays."""

    K_t: Annotated[float, quantity("N m/A", gt=0)]
    I_peak: Annotated[float, quantity("A", gt=0)]
    I_step: Annotated[float, quantity("A", ge=0)]
    f_current: Annotated[float, quantity("Hz", gt=0)]
    t_command: Annotated[float, quantity("s", ge=0, le=0.01)]
    t_measurement: Annotated[float, quantity("s", ge=0, le=0.01)]

    @property
    def tau_max(self) -> float:
        """Torque limit [N m]."""
        return float(self.K_t * self.I_peak)


class Encoder(_Section):
    """Angle step [rad]; zero means no quantisation."""

    step: Annotated[float, quantity("rad", ge=0)]


class Timing(_Section):
    """Base step and sample times [s]; the latter are whole numbers of base steps."""

    base: Annotated[float, quantity("s", gt=0)]
    feedforward: Annotated[float, quantity("s", gt=0)]
    adaptation: Annotated[float, quantity("s", gt=0)]

    @model_validator(mode="after")
    def _whole(self) -> Timing:
        for name in ("feedforward", "adaptation"):
            steps = getattr(self, name) / self.base
            if abs(steps - round(steps)) > 1e-9 or round(steps) < 1:
                raise ValueError(f"{name} is {steps:.6g} base steps, must be a whole number")
        return self


class Control(_Section):
    """Feedback design and Kalman filter; R1, P0 are normalised, R2 [N2 m2]."""

    f_crossover: Annotated[float, quantity("Hz", gt=0)]
    phase_margin: Annotated[float, quantity("rad", gt=0, le=1.5)]
    integrator_ratio: Annotated[float, quantity("1", gt=1)]
    J_design: Annotated[float, quantity("kg m2", gt=0)]
    hann_points: Annotated[int, Field(ge=3, le=1001)]
    R1: Annotated[float, quantity("1", ge=0)]
    R1_end_effector: Annotated[float, quantity("1", ge=0)]
    R2: Annotated[float, quantity("N2 m2", gt=0)]
    P0: Annotated[float, quantity("1", gt=0)]


class Reference(_Section):
    """Default experiment: random setpoints within +-amplitude [rad], one each period [s]."""

    amplitude: Annotated[float, quantity("rad", gt=0)]
    period: Annotated[float, quantity("s", gt=0)]
    move: Annotated[float, quantity("s", gt=0)]
    duration: Annotated[float, quantity("s", gt=0)]


class Machine(_Section):
    """Everything that is known about one machine, in SI units."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]*$")]
    gravity: Gravity
    geometry: Geometry
    arms: Annotated[tuple[Arm, ...], Field(min_length=6, max_length=6)]
    bodies: Bodies
    flexures: Flexures
    actuator: Actuator
    drive: Drive
    encoder: Encoder
    timing: Timing
    control: Control
    reference: Reference

    @property
    def n_arms(self) -> int:
        """Number of arms and actuators."""
        return len(self.arms)

    @model_validator(mode="after")
    def _drive_delays(self) -> Machine:
        for name in ("t_command", "t_measurement"):
            steps = getattr(self.drive, name) / self.timing.base
            if abs(steps - round(steps)) > 1e-9:
                raise ValueError(f"drive.{name} is {steps:.6g} base steps, must be a whole number")
        return self

    @model_validator(mode="after")
    def _actuators(self) -> Machine:
        n, harmonics = self.n_arms, self.actuator.n_harmonics
        for name in ("o", "k", "d", "c", "a", "b"):
            rows = getattr(self.actuator, name)
            if len(rows) != n:
                raise ValueError(f"actuator.{name} has {len(rows)} entries for {n} arms")
        for name in ("a", "b"):
            for i, row in enumerate(getattr(self.actuator, name), start=1):
                if len(row) != harmonics:
                    raise ValueError(f"actuator.{name}, row {i}: {len(row)} of {harmonics} values")
        return self


def symmetric(six: Vector) -> np.ndarray:
    """Matrix (3, 3) from xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def load_machine(path: str | Path) -> Machine:
    """Read and check a machine file.

    Raises MachineError when the file is missing, is no TOML, lacks a field or has an
    unknown one, holds a wrong unit or an impossible value, or when the mechanism
    does not close at the neutral pose.
    """
    from fmus.common.geometry import Frames

    data = read_toml(path)
    try:
        machine = Machine.model_validate(data)
    except ValidationError as error:
        raise MachineError("\n".join(complaint(path, e) for e in error.errors())) from None
    Frames.of(machine, where=str(path))
    return machine


def read_toml(path: str | Path) -> dict[str, Any]:
    """Plain data of a TOML file; MachineError when it is missing or no TOML."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a UTF-8 text"
        raise MachineError(f"{path}: cannot be read ({reason})") from None
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"{path}: not valid TOML: {error}") from None


def complaint(path: str | Path, error: Any) -> str:
    where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in error["loc"])
    text = error["msg"].removeprefix("Value error, ")
    if error["type"] == "missing":
        text = "is missing"
    elif error["type"] == "extra_forbidden":
        text = "is not a known key: correct its spelling or take it out"
    return f"{path}: {where + ': ' if where else ''}{text}"
