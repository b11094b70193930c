"""Dry friction and drag: torques of the rate alone."""

from __future__ import annotations

import casadi as ca

from fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shape, Shapes, Signals

SMOOTHING = Shape(
    "v0",
    "rad/s",
    low=2e-4,
    high=0.1,
    start=0.002,
    grid=(5e-4, 0.002, 0.01),
    description="rate within which the sign turns over; needs F Ts / (J v0) < 2.8",
)
SLOW = Experiment("triangle", {"speed": 0.05, "amplitude": 0.19})


class CoulombFriction(Effect):
    """F_c tanh(thetad / v0): the smooth sign keeps the integration well-behaved."""

    id, title, acts_on = "coulomb_friction", "Coulomb friction", "torque"
    gains = (Gain("F_c", "N m", 0.02, 0.0, 5.0, "friction torque"),)
    shapes = (SMOOTHING,)
    excites = "reversals of the motion at several angles; constant speeds between them"
    confused_with = ("stribeck_friction", "second_hysteresis")
    experiment = "slow triangle: long stretches of one speed, sharp reversals"
    spec = SLOW

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.tanh(s.thetad / shape["v0"])


class StribeckFriction(Effect):
    """F_s exp(-(thetad / v_s)^2) tanh(thetad / v0): what friction has more when slow."""

    id, title, acts_on = "stribeck_friction", "Stribeck friction", "torque"
    gains = (Gain("F_s", "N m", 0.02, 0.0, 5.0, "breakaway torque beyond Coulomb's"),)
    shapes = (
        Shape("v_s", "rad/s", 1e-3, 2.0, 0.05, (0.01, 0.05, 0.2), "Stribeck rate"),
        SMOOTHING,
    )
    excites = "very slow motion beside fast motion"
    confused_with = ("coulomb_friction", "second_hysteresis")
    experiment = "triangles below and above the Stribeck rate"
    spec = Experiment("triangle", {"speed": 0.02, "amplitude": 0.1})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.exp(-((s.thetad / shape["v_s"]) ** 2)) * ca.tanh(s.thetad / shape["v0"])


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
