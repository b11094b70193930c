"""A gear that gives way between the motor, whose encoder is read, and the link."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shapes, Signals


class JointElasticity(Effect):
    """c tau - d theta'' [rad]: the encoder at the motor reads tau / k more than the link has
    turned, c = 1 / k, of the torque tau that the rotor leaves.

    An elastic joint (Spong, 1987) with the torque that is measured in the place of the spring's, so
    that its mode is in it. How much the rotor leaves is known as well as its inertia is, which a
    stiff machine hardly shows: d is c times what that is larger than the model has it.
    """

    id, title, acts_on = "joint_elasticity", "elastic joint", "measurement"
    gains = (
        Gain("c", "rad/N m", 1e-4, 0.0, 0.05, "compliance"),
        Gain("d", "s2", 1e-6, -0.05, 0.05, "compliance times what the rotor has more of inertia"),
    )
    geared, size = True, "c"
    excites = "poses in which gravity loads the joint, then fast motion"
    confused_with = ("flexible_mode", "encoder_eccentricity")
    experiment = "slow triangle through as much of the stroke as possible, then without payload"
    spec = Experiment("triangle", {"speed": 0.1, "amplitude": 0.3})
    feedforward = (
        "the feedback follows the motor's angle, so torque alone cannot mend it: add c tau to the"
        " motor's reference, or measure behind the gear"
    )

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.vertcat(s.tau, -s.thetadd)

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        """Where the encoder is taken to be."""
        return "with the encoder at the motor; behind the spring c would be another"


EFFECT = JointElasticity()
