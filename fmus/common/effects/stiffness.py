"""Torques of the angle alone: offsets, springs, cables that tighten."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from flexhex.fmus.common.effects.effect import (
    Effect,
    Experiment,
    Expr,
    Gain,
    Shape,
    Shapes,
    Signals,
)

WIDE = Experiment("triangle", {"speed": 0.1, "amplitude": 0.3})


class TorqueOffset(Effect):
    """o, always: zero of a torque or current sensor, a counterbalance of constant force."""

    id, title, acts_on = "torque_offset", "constant torque", "torque"
    gains = (Gain("o", "N m", 0.02, -1e5, 1e5, "torque at any angle"),)
    exact, usual = True, 0.03
    excites = "motion both ways through several angles"
    confused_with = ("coulomb_friction", "linear_stiffness", "gravity_tilt")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = WIDE

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.SX.ones(1)


class LinearStiffness(Effect):
    """o + k_1 theta: a spring, a hose or a cable pack that is at rest at theta = -o / k_1."""

    id, title, acts_on = "linear_stiffness", "linear stiffness", "torque"
    gains = (
        Gain("o", "N m", 0.02, -1e5, 1e5, "torque at zero angle"),
        Gain("k_1", "N m/rad", 0.1, 0.0, 1e6, "torque per angle: a spring pulls back"),
    )
    extends = "torque_offset"
    excites = "the whole stroke"
    confused_with = ("cable_force", "quadratic_stiffness", "gravity_tilt")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = WIDE

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.vertcat(1, s.theta)

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        """Where the spring is at rest."""
        if not values["k_1"]:
            return ""
        length = units["k_1"].partition("/")[2]
        return f"no torque at {-values['o'] / values['k_1']:.3g} {length}"


class QuadraticStiffness(Effect):
    """k_2 theta^2."""

    id, title, acts_on = "quadratic_stiffness", "quadratic stiffness", "torque"
    gains = (Gain("k_2", "N m/rad2", 0.2, -1e6, 1e6, "torque per square of the angle"),)
    excites = "the whole stroke"
    confused_with = ("cable_force", "cogging_harmonic", "gravity_tilt")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = WIDE

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.theta**2


class CubicStiffness(Effect):
    """k_3 theta^3."""

    id, title, acts_on = "cubic_stiffness", "cubic stiffness", "torque"
    gains = (Gain("k_3", "N m/rad3", 1.0, -1e7, 1e7, "torque per cube of the angle"),)
    excites = "the whole stroke"
    confused_with = ("cable_force", "cogging_harmonic")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = WIDE

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.theta**3


PLACES = (-0.1, -0.05, 0.0, 0.05, 0.1)


class CableForce(Effect):
    """k_c side max(0, side (theta - theta_0)): a cable pulls back beyond theta_0."""

    id, title, acts_on = "cable_force", "cable force", "torque"
    gains = (Gain("k_c", "N m/rad", 0.1, 0.0, 1e6, "stiffness where it is tight"),)
    shapes = (
        Shape("theta_0", "rad", -1.5, 1.5, 0.05, PLACES, "where it begins", of_place=True),
        Shape("side", "1", -1.0, 1.0, 1.0, (-1.0, 1.0), "1: above theta_0, -1: below", whole=True),
    )
    most = 2
    excites = "angles on both sides of where it begins"
    confused_with = ("quadratic_stiffness", "cubic_stiffness")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = WIDE

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        side = shape["side"]
        return side * ca.fmax(0, side * (s.theta - shape["theta_0"]))


EFFECTS = (
    TorqueOffset(),
    LinearStiffness(),
    QuadraticStiffness(),
    CubicStiffness(),
    CableForce(),
)
