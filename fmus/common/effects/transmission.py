"""A gear that does not turn evenly."""

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
from flexhex.fmus.common.effects.harmonics import ORDERS


class TransmissionError(Effect):
    """e_c (cos order theta - 1) + e_s sin order theta [rad]: the encoder at the motor reads this
    more than the link has turned.

    The kinematic error of a gear (Tuttle and Seering, 1996, of harmonic drives). At speed the link
    is shaken by it, so that the torque grows with the square of the rate; at rest the motor feels a
    load that varies with the slope of the error.
    """

    id, title, acts_on = "transmission_error", "transmission error", "measurement"
    gains = (
        Gain("e_c", "rad", 1e-4, -0.02, 0.02, "cosine amplitude"),
        Gain("e_s", "rad", 1e-4, -0.02, 0.02, "sine amplitude"),
    )
    shapes = (
        Shape(
            "order",
            "1/rad",
            low=0.0,
            high=1e5,
            start=360.0,
            grid=ORDERS,
            description="multiple of the angle; of a harmonic drive twice its ratio",
        ),
    )
    geared, most, exact = "angle", 8, True
    excites = "the whole stroke, at several speeds"
    confused_with = ("torque_ripple", "cogging_harmonic", "joint_elasticity")
    experiment = "triangles through the stroke, a slow and a fast one"
    spec = Experiment("triangle", {"speed": 0.5, "amplitude": 0.3})
    feedforward = (
        "the feedback follows the motor's angle, so torque alone cannot mend it: add the error to"
        " the motor's reference, or measure behind the gear"
    )

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        angle = shape["order"] * s.theta
        return ca.vertcat(ca.cos(angle) - 1, ca.sin(angle))


EFFECT = TransmissionError()
