"""A machine is data: `Machine` holds what `machines/*.toml` says, in SI units, checked.

`machine_file.py` reads it from a file, `sections.py` has its parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, model_validator

from flexhex.fmus.common.effects.steep import steepest
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.fmus.common.machine.sections import (
    Actuator,
    Arm,
    Bodies,
    Body,
    Control,
    Drive,
    Encoder,
    EndEffector,
    Flexures,
    Geometry,
    Gravity,
    Matrix,
    Reference,
    Section,
    Timing,
    Tolerance,
    Vector,
)

RK4_REACH = 2.78
"""A Runge-Kutta step h of order four is stable for dz/dt = -a z up to a h = 2.78."""

STIFFEST = 0.002
"""Stiffness of dry friction that has not yet given way, k Ts^2 / J of a joint, that the plant's
steps integrate. Measured on the default machine: with 0.007 it runs away, with 0.0022 not."""
STEEP, RUBBING = 0.001, 2.0
"""Slopes of a user's torque over the angle, k Ts^2 / J, and over the rate, d Ts / J, that the loop
bears. Measured on the default machine, 2 s of one motion, with the torque in the feedforward: up to
0.001 and 2 it tracks within 20 urad, with 0.002 it runs away, with 3 it errs by 200 urad. A torque
that falls with the angle runs away from -0.0005 on: that is the loop's own limit, not refused."""
ROUNDED = 1e-3
"""Relative excess that the digits of a file may make."""


@dataclass(frozen=True)
class Platform:
    """Lower arms and end-effector: l [m], x_E0 (3,) [m], r_EP (n_arms, 3) [m], bodies, flexures."""

    l: float  # noqa: E741 - the paper's neighbour of L
    x_E0: Vector
    r_EP: Matrix
    lower: Body
    end_effector: EndEffector
    flexures: Flexures


class Machine(Section):
    """Everything that is known about one machine, in SI units."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]*$")]
    gravity: Gravity
    geometry: Geometry
    arms: Annotated[tuple[Arm, ...], Field(min_length=6, max_length=6)]
    bodies: Bodies
    flexures: Flexures | None = None
    actuator: Actuator
    drive: Drive
    encoder: Encoder
    timing: Timing
    control: Control
    reference: Reference
    effects: tuple[EffectUse, ...] = ()
    tolerance: Tolerance = Tolerance()

    @property
    def softest(self) -> float:
        """Least angle within which dry friction gives way, of its torque [rad/(N m)]."""
        return float(self.timing.base**2 / (STIFFEST * self.control.J_design))

    def too_steep(self, use: EffectUse) -> str:
        """Why the plant's steps cannot follow an effect of the user's own, or nothing."""
        if use.own is None:
            return ""
        made, inertia, base = use.own.function(use.shape), self.control.J_design, self.timing.base
        speed = 4 * self.reference.amplitude / self.reference.move
        lines = (
            ("theta", self.geometry.stroke, STEEP * inertia / base**2, "N m/rad"),
            ("thetad", speed, RUBBING * inertia / base, "N m s/rad"),
        )
        for gains in zip(*use.gains, strict=True):
            for signal, half, most, unit in lines:
                slope, at = steepest(made, gains, signal, half)
                if slope > most:
                    return (
                        f"{use.id} changes by {slope:.3g} {unit} at {signal} = {at:.3g}, at most"
                        f" {most:.3g} {unit}: plant and loop cannot follow; make"
                        " it smoother, as np.tanh(x / width) does, or smaller"
                    )
        return ""

    @property
    def n_arms(self) -> int:
        """Number of arms and actuators."""
        return len(self.arms)

    @property
    def has_platform(self) -> bool:
        """False for the actuators alone: upper arms without Q_i and E."""
        return self.flexures is not None

    @property
    def platform(self) -> Platform:
        """What stands on the upper arms. MachineError when the machine has none."""
        g, b, f = self.geometry, self.bodies, self.flexures
        r_EP = tuple(arm.r_EP for arm in self.arms if arm.r_EP is not None)
        if not (g.l and g.x_E0 and b.lower and b.end_effector and f and len(r_EP) == self.n_arms):
            raise MachineError(f"{self.name} has no platform, only its actuators")
        return Platform(g.l, g.x_E0, r_EP, b.lower, b.end_effector, f)

    @model_validator(mode="after")
    def _whole_platform(self) -> Machine:
        parts = {
            "geometry.l": self.geometry.l,
            "geometry.x_E0": self.geometry.x_E0,
            "bodies.lower": self.bodies.lower,
            "bodies.end_effector": self.bodies.end_effector,
            "flexures": self.flexures,
            **{f"arms.{i}.r_EP": arm.r_EP for i, arm in enumerate(self.arms, start=1)},
        }
        missing = [name for name, part in parts.items() if part is None]
        if missing and len(missing) < len(parts):
            raise ValueError(
                f"{missing[0]} is missing: give all of the platform, or nothing of it"
                " for the actuators alone"
            )
        return self

    @model_validator(mode="after")
    def _drive_delays(self) -> Machine:
        for name in ("t_command", "t_measurement"):
            steps = getattr(self.drive, name) / self.timing.base
            if abs(steps - round(steps)) > 1e-9:
                raise ValueError(f"drive.{name} is {steps:.6g} base steps, must be a whole number")
        return self

    @model_validator(mode="after")
    def _experiment(self) -> Machine:
        base, ref = self.timing.base, self.reference
        if ref.amplitude > self.geometry.stroke:
            raise ValueError(
                f"reference.amplitude is {ref.amplitude:.6g} rad, must be within"
                f" geometry.stroke, {self.geometry.stroke:.6g} rad"
            )
        steps = ref.period / base
        if abs(steps - round(steps)) > 1e-6:
            raise ValueError(
                f"reference.period is {steps:.9g} base steps, must be a whole number:"
                " change it or timing.base"
            )
        return self

    @model_validator(mode="after")
    def _dahl_width(self) -> Machine:
        # rate of the longest move at its middle, and as much again for what feedback adds
        speed = 2 * 4 * self.reference.amplitude / self.reference.move
        least = speed * self.timing.base / RK4_REACH
        if self.actuator.sigma < least:
            raise ValueError(
                f"actuator.sigma is {self.actuator.sigma:.3g} rad, at least {least:.3g} rad are"
                f" needed: the plant's steps of timing.base cannot follow the hysteresis at"
                f" {speed:.3g} rad/s; widen sigma or shorten timing.base"
            )
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

    @model_validator(mode="after")
    def _effects(self) -> Machine:
        seen = set[tuple[str, int, tuple[float, ...]]]()
        for k, use in enumerate(self.effects, start=1):
            for axis in use.axes or (0,):
                if axis > self.n_arms:
                    raise ValueError(
                        f"effects.{k}: axes: {axis}, {use.id} can act on 1 to {self.n_arms}"
                    )
                if (use.id, axis, use.shapes) in seen:
                    raise ValueError(
                        f"effects.{k}: {use.id} is there already"
                        + (f" on axis {axis} with the same shape" if axis else "")
                        + ": keep one of them"
                    )
                seen.add((use.id, axis, use.shapes))
        return self

    @model_validator(mode="after")
    def _dry_friction(self) -> Machine:
        for k, use in enumerate(self.effects, start=1):
            s_0 = use.shape.get("s_0", math.inf)
            torques = [
                row for row, g in zip(use.gains, use.effect.gains, strict=True) if g.unit == "N m"
            ]
            least = self.softest * max(map(sum, zip(*torques, strict=True)), default=0.0)
            if s_0 < least / (1 + ROUNDED):
                raise ValueError(
                    f"effects.{k}: {use.id} gives way within s_0 = {s_0:.3g} rad, at least"
                    f" {least:.3g} rad are needed: the plant's steps of timing.base cannot follow"
                    " friction that stiff; widen s_0 or shorten timing.base"
                )
        return self

    @model_validator(mode="after")
    def _own_effects(self) -> Machine:
        for k, use in enumerate(self.effects, start=1):
            if why := self.too_steep(use):
                raise ValueError(f"effects.{k}: {why}")
        return self
