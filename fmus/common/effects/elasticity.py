"""A gear that gives way between the motor, whose encoder is read, and the link."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shapes, Signals


class JointElasticity(Effect):
    """c tau [rad]: the encoder at the motor reads tau / k more than the link has turned, c = 1 / k.

    First order of an elastic joint (Spong, 1987): the link follows without a mode of its own, which
    a flexible mode would add.
    """

    id, title, acts_on = "joint_elasticity", "elastic joint", "measurement"
    gains = (Gain("c", "rad/N m", 1e-4, 0.0, 0.05, "compliance"),)
    geared = True
    excites = "poses in which gravity loads the joint, then fast motion"
    confused_with = ("flexible_mode", "encoder_eccentricity")
    experiment = "slow triangle through as much of the stroke as possible, then without payload"
    spec = Experiment("triangle", {"speed": 0.1, "amplitude": 0.3})
    feedforward = (
        "the feedback follows the motor's angle, so torque alone cannot mend it: add c tau to the"
        " motor's reference, or measure behind the gear"
    )

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.tau


EFFECT = JointElasticity()
