"""Errors of the angle that the encoder reads."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shapes, Signals


class EncoderEccentricity(Effect):
    """e_c (cos theta - 1) + e_s sin theta [rad]: the ring turns about another point.

    The encoder is zeroed at the neutral pose, hence the - 1.
    """

    id, title, acts_on = "encoder_eccentricity", "eccentric encoder ring", "measurement"
    gains = (
        Gain("e_c", "rad", 1e-4, -0.02, 0.02, "cosine amplitude"),
        Gain("e_s", "rad", 1e-4, -0.02, 0.02, "sine amplitude"),
    )
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
        return ca.vertcat(ca.cos(s.theta) - 1, ca.sin(s.theta))


EFFECT = EncoderEccentricity()
