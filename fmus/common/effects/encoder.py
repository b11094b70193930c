"""Errors of the angle that the encoder reads."""

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

PERIODS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0)
"""Those that are tried."""


class EncoderEccentricity(Effect):
    """e_c (cos k theta - 1) + e_s sin k theta [rad]: the ring turns about another point, k = 1.

    A ring that is oval, or read by two heads, errs twice a turn; a resolver or an inductive encoder
    as often as it has pairs of poles. The encoder is zeroed at the neutral pose, hence the - 1.
    """

    id, title, acts_on = "encoder_eccentricity", "eccentric encoder ring", "measurement"
    gains = (
        Gain("e_c", "rad", 1e-4, -0.02, 0.02, "cosine amplitude"),
        Gain("e_s", "rad", 1e-4, -0.02, 0.02, "sine amplitude"),
    )
    shapes = (Shape("k", "1", 1.0, 64.0, 1.0, PERIODS, "periods per turn", whole=True, as_is=True),)
    turning = True
    excites = "the whole stroke, with much cogging"
    confused_with = ("cogging_harmonic", "quadratic_stiffness")
    experiment = "slow triangle through as much of the stroke as possible"
    spec = Experiment("triangle", {"speed": 0.1, "amplitude": 0.3})
    feedforward = (
        "the feedback follows the angle that is read, so torque alone cannot mend it: correct"
        " the reading by a calibration table of the encoder"
    )

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        angle = shape["k"] * s.theta
        return ca.vertcat(ca.cos(angle) - 1, ca.sin(angle))


EFFECT = EncoderEccentricity()
