"""The sections of a machine file: what each field is, its unit and its range.

`machine.py` puts them together. A model validator here looks at one section alone.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.quantity import quantity

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]


class Section(BaseModel):
    """Frozen, and strict about unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Gravity(Section):
    """g (3,) [m/s2] in the world frame, z up."""

    g: Annotated[Vector, quantity("m/s2", 3)]


class Geometry(Section):
    """L, l: upper and lower arm [m]; x_E0 (3,): neutral position of E [m]; stroke [rad].

    l and x_E0 are absent where a machine has no platform.
    """

    L: Annotated[float, quantity("m", gt=0)]
    l: Annotated[float | None, quantity("m", gt=0)] = None  # noqa: E741 - neighbour of L
    x_E0: Annotated[Vector | None, quantity("m", 3)] = None
    stroke: Annotated[float, quantity("rad", gt=0, le=1.5)]


class Arm(Section):
    """One arm in the world frame at the neutral pose; a positive angle turns about `axis`.

    x_B (3,) [m]: point on the motor axis; axis, u_B (3,): unit vectors of the motor axis and
    along the upper arm, at right angles; r_EP (3,) [m]: spherical joint in E.
    """

    x_B: Annotated[Vector, quantity("m", 3)]
    axis: Annotated[Vector, quantity("1", 3)]
    u_B: Annotated[Vector, quantity("1", 3)]
    r_EP: Annotated[Vector | None, quantity("m", 3)] = None

    @model_validator(mode="after")
    def _frame(self) -> Arm:
        axis, u = np.array(self.axis), np.array(self.u_B)
        for name, v in (("axis", axis), ("u_B", u)):
            if abs(np.linalg.norm(v) - 1) > 1e-9:
                raise ValueError(f"{name} has length {np.linalg.norm(v):.12g}, must be 1")
        if abs(axis @ u) > 1e-9:
            raise ValueError("u_B is not at right angles to axis")
        return self


class Body(Section):
    """m [kg], centre of mass c (3,) [m], Ic (6,) [kg m2]: xx, yy, zz, xy, xz, yz about it."""

    m: Annotated[float, quantity("kg", gt=0)]
    c: Annotated[Vector, quantity("m", 3)]
    Ic: Annotated[Vector, quantity("kg m2", 6)]

    @model_validator(mode="after")
    def _physical(self) -> Body:
        principal = np.linalg.eigvalsh(inertia_rows(self.Ic))
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


class Bodies(Section):
    """The three kinds of bodies; all arms are alike. Without a platform: upper arms alone."""

    upper: UpperArm
    lower: Body | None = None
    end_effector: EndEffector | None = None


class Flexures(Section):
    """Joint stiffness [N m/rad]: k_u (2,) universal bendings, k_s (2,) spherical twist, bending.

    It multiplies the deformations of [SH, Eq. (18)], half the antisymmetric part of the relative
    rotation matrix: the sine of the angle where a joint turns about one axis.
    """

    k_u: Annotated[Vector, quantity("N m/rad", 2, ge=0)]
    k_s: Annotated[Vector, quantity("N m/rad", 2, ge=0)]


class Actuator(Section):
    """The terms of [SH, Eq. (22)] for each of the actuators; a, b (n_arms, n_harmonics)."""

    sigma: Annotated[float, quantity("rad", gt=0)]
    omega_cog: Annotated[float, quantity("1/rad", gt=0)]
    n_harmonics: Annotated[int, Field(ge=1, le=20, strict=True)]
    o: Annotated[Vector, quantity("N m", -1)]
    k: Annotated[Vector, quantity("N m/rad", -1)]
    d: Annotated[Vector, quantity("N m s/rad", -1, ge=0)]
    c: Annotated[Vector, quantity("N m", -1, ge=0)]
    a: Annotated[Matrix, quantity("N m", -1, -1)]
    b: Annotated[Matrix, quantity("N m", -1, -1)]


class BodyTolerance(Section):
    """How well any file knows bodies: one standard deviation each, relative; centre and geometry
    relative to a length of the mechanism, geometry of angles in rad."""

    mass: Annotated[float, quantity("1", gt=0, le=1)] = 0.05
    inertia: Annotated[float, quantity("1", gt=0, le=1)] = 0.05
    centre: Annotated[float, quantity("1", gt=0, le=1)] = 0.005
    geometry: Annotated[float, quantity("1", ge=0, le=0.1)] = 0.002


class Tolerance(BodyTolerance):
    """How well the file's values are known: one standard deviation each, relative, by which a
    machine may differ without the diagnosis reporting it.

    mass, inertia: of bodies; centre: of centres of mass, relative to the longer of L and l;
    geometry: of places and lengths, relative to the longer of L and l, and of angles [rad];
    stiffness: of the flexures; actuator: of its terms; sigma: of the hysteresis' width.

    Masses of real files are 1 to 10 % wrong, evenly on a logarithmic scale: 5 % RMS. Inertias are
    no better known. Centres follow: 5 % of a body's reach, which is about a tenth of an arm.
    Stiffness and torque terms as calibrated ones repeat. Parts that are machined and assembled,
    not calibrated, are 0.1 to 0.5 % off.
    """

    stiffness: Annotated[float, quantity("1", gt=0, le=1)] = 0.05
    actuator: Annotated[float, quantity("1", gt=0, le=1)] = 0.05
    sigma: Annotated[float, quantity("1", gt=0, le=1)] = 0.1


class Drive(Section):
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


class Encoder(Section):
    """Angle step [rad]; zero means no quantisation."""

    step: Annotated[float, quantity("rad", ge=0)]


class Timing(Section):
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


class Control(Section):
    """Feedback design and Kalman filter; R1, P0 are normalised, R2 [N2 m2]."""

    f_crossover: Annotated[float, quantity("Hz", gt=0)]
    phase_margin: Annotated[float, quantity("rad", gt=0, le=1.5)]
    integrator_ratio: Annotated[float, quantity("1", gt=1)]
    J_design: Annotated[float, quantity("kg m2", gt=0)]
    hann_points: Annotated[int, Field(ge=3, le=1001, strict=True)]
    R1: Annotated[float, quantity("1", ge=0)]
    R1_end_effector: Annotated[float, quantity("1", ge=0)]
    R2: Annotated[float, quantity("N2 m2", gt=0)]
    P0: Annotated[float, quantity("1", gt=0)]


class Reference(Section):
    """Default experiment: random setpoints within +-amplitude [rad], one each period [s]."""

    amplitude: Annotated[float, quantity("rad", gt=0)]
    period: Annotated[float, quantity("s", gt=0)]
    move: Annotated[float, quantity("s", gt=0)]
    duration: Annotated[float, quantity("s", gt=0)]

    @model_validator(mode="after")
    def _fits(self) -> Reference:
        if self.move > self.period:
            raise ValueError(f"move is {self.move:.6g} s, longer than period, {self.period:.6g} s")
        count = self.duration / self.period
        if abs(count - round(count)) > 1e-6 or round(count) < 1:
            raise ValueError(
                f"duration is {count:.6g} times period, must be a whole number:"
                f" {max(1, round(count)) * self.period:.6g} s would be"
            )
        return self
