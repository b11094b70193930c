"""Torques that repeat with the angle: cogging beyond the model, ripple of the motor constant."""

from __future__ import annotations

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

SWEEP = Experiment("triangle", {"speed": 0.1, "amplitude": 0.19})
ORDERS = tuple(float(k) for k in range(24, 721, 6))
"""Orders to try: over 0.4 rad two of them are distinguishable when they differ by 2 pi / 0.4 = 16,
and below 24 there are fewer than one and a half periods."""


class CoggingHarmonic(Effect):
    """a cos(order theta) + b sin(order theta): one harmonic that the model does not have."""

    id, title, acts_on = "cogging_harmonic", "cogging harmonic", "torque"
    gains = (
        Gain("a", "N m", 0.004, -1e4, 1e4, "cosine amplitude"),
        Gain("b", "N m", 0.004, -1e4, 1e4, "sine amplitude"),
    )
    shapes = (
        Shape(
            "order",
            "1/rad",
            low=0.0,
            high=1e5,
            start=360.0,
            grid=tuple(k for k in ORDERS if k % 36 or k > 324),
            description="multiple of the angle; the poles of the motor times a whole number",
        ),
    )
    most, exact = 8, True
    excites = "the whole stroke, slowly"
    confused_with = ("torque_ripple", "cubic_stiffness", "quadratic_stiffness")
    experiment = "slow triangle through the stroke: every angle at a steady speed"
    spec = SWEEP

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        angle = shape["order"] * s.theta
        return ca.vertcat(ca.cos(angle), ca.sin(angle))


class TorqueRipple(Effect):
    """(a cos(order theta) + b sin(order theta)) tau: the motor constant varies with the angle."""

    id, title, acts_on = "torque_ripple", "torque ripple", "drive"
    gains = (
        Gain("a", "1", 0.005, -0.5, 0.5, "cosine amplitude, relative"),
        Gain("b", "1", 0.005, -0.5, 0.5, "sine amplitude, relative"),
    )
    shapes = (
        Shape(
            "order",
            "1/rad",
            low=0.0,
            high=1e5,
            start=36.0,
            grid=ORDERS,
            description="multiple of the angle",
        ),
    )
    most, exact = 8, True
    excites = "the same angles under different torques: another payload, another speed"
    confused_with = ("cogging_harmonic", "drive_gain")
    experiment = "the slow triangle with and without payload"
    spec = Experiment("triangle", {"speed": 0.1, "amplitude": 0.19}, ((0.0, 0.0), (25.0, 1.0)))

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        angle = shape["order"] * s.theta
        return ca.vertcat(s.tau * ca.cos(angle), s.tau * ca.sin(angle))


EFFECTS = (CoggingHarmonic(), TorqueRipple())
