"""Dry friction and drag."""

from __future__ import annotations

from typing import Any

import casadi as ca

from fmus.common import actuator
from fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shape, Shapes, Signals, State

PRESLIDING = Shape(
    "s_0",
    "rad",
    low=4e-4,
    high=6e-3,
    start=1e-3,
    grid=(4e-4, 1e-3, 2.5e-3, 5e-3),
    description="angle within which the torque turns over after a reversal",
)
SLOW = Experiment("triangle", {"speed": 0.05, "amplitude": 0.19})


class DryFriction(Effect):
    """Dry friction with presliding: z follows the motion within an angle s_0, as Dahl has it."""

    states = (State("z_0", "1"),)

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return (s.thetad - ca.fabs(s.thetad) * state) / shape["s_0"]

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for a step of one sign, whatever the rate does meanwhile."""
        return actuator.dahl(state, now.theta - before.theta, shape["s_0"])


class CoulombFriction(DryFriction):
    """F_c z_0, z_0' = (thetad - |thetad| z_0) / s_0: the sign of the motion after s_0.

    Real contacts give way a little before they slide; a wider s_0 is a hysteresis of its own.
    """

    id, title, acts_on = "coulomb_friction", "Coulomb friction", "torque"
    gains = (Gain("F_c", "N m", 0.02, 0.0, 5.0, "friction torque"),)
    shapes = (PRESLIDING,)
    excites = "reversals of the motion at several angles; constant speeds between them"
    confused_with = ("stribeck_friction", "second_hysteresis")
    experiment = "slow triangle: long stretches of one speed, sharp reversals"
    spec = SLOW

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return state


class StribeckFriction(DryFriction):
    """(F_c + F_s exp(-(thetad / v_s)^2)) z_0: friction that is larger when slow.

    A contact with a breakaway torque has a friction torque too, so both are one effect; without
    F_s it is Coulomb's.
    """

    id, title, acts_on = "stribeck_friction", "Stribeck friction", "torque"
    gains = (
        Gain("F_c", "N m", 0.02, 0.0, 5.0, "friction torque when fast"),
        Gain("F_s", "N m", 0.02, 0.0, 5.0, "breakaway torque beyond it"),
    )
    shapes = (
        Shape("v_s", "rad/s", 1e-3, 0.3, 0.05, (0.01, 0.03, 0.1), "Stribeck rate"),
        PRESLIDING,
    )
    excites = "very slow motion beside fast motion"
    confused_with = ("coulomb_friction", "second_hysteresis")
    experiment = "triangles below and above the Stribeck rate"
    spec = Experiment("triangle", {"speed": 0.02, "amplitude": 0.1})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.vertcat(state, ca.exp(-((s.thetad / shape["v_s"]) ** 2)) * state)


class QuadraticDrag(Effect):
    """D_2 thetad |thetad|: drag of the air or of a churning fluid."""

    id, title, acts_on = "quadratic_drag", "quadratic drag", "torque"
    gains = (Gain("D_2", "N m s2/rad2", 0.005, 0.0, 10.0, "drag"),)
    excites = "fast moves of different speeds"
    confused_with = ("coulomb_friction", "torque_constant_saturation")
    experiment = "random setpoints, the faster the better"
    spec = Experiment("random", {"period": 0.7, "move": 0.4})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.thetad * ca.fabs(s.thetad)


EFFECTS = (CoulombFriction(), StribeckFriction(), QuadraticDrag())
