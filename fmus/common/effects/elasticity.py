"""A gear that gives way between the motor, whose encoder is read, and the link."""

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

SHARPER = 6
"""Ratio of the rates within which parts of dry friction reverse: together they are like friction of
any rate between. With 4 and with 9 two simulated arms have the same elastic joint; with 9 one has
its stiff one, too."""


class JointElasticity(Effect):
    """c tau - d theta'' [rad]: the encoder at the motor reads tau / k more than the link has
    turned, c = 1 / k, of the torque tau that the rotor leaves.

    An elastic joint (Spong, 1987) with the torque that is measured in the place of the spring's, so
    that its mode is in it. How much the rotor leaves is known as well as its inertia is, which a
    stiff machine hardly shows: d is c times what that is larger than the model has it. Friction of
    the motor does not bend the gear either. It reverses within milliseconds, so that its second
    derivative is as large as what the gear does. So c times that friction is fitted with the
    effect, as viscous and as dry friction that reverses within three rates, and need not be known.
    """

    id, title, acts_on = "joint_elasticity", "elastic joint", "measurement"
    gains = (
        Gain("c", "rad/N m", 1e-4, 0.0, 0.05, "compliance"),
        Gain(
            "d",
            "s2",
            1e-6,
            -0.05,
            0.05,
            "compliance times what the rotor has more of inertia",
            below=("c", 1.0),
            of="inertia",
        ),
    )
    aside = (
        Gain(
            "dry",
            "rad",
            1e-4,
            0.0,
            description="c times dry friction",
            below=("c", 1.0),
            of="torque",
        ),
        Gain("sharp", "rad", 1e-4, description="the part of it that reverses within v_m / 6"),
        Gain("sharper", "rad", 1e-4, description="the part of it that reverses within v_m / 36"),
        Gain("viscous", "s", 1e-4, 0.0, description="c times viscous friction"),
    )
    shapes = (
        Shape(
            "v_m",
            "rad/s",
            low=1e-3,
            high=1.0,
            start=0.1,
            grid=(0.1,),
            description="largest rate within which dry friction of the motor reverses",
            aside=True,
        ),
        Shape(
            "smooth",
            "1",
            low=3.0,
            high=6.0,
            start=4.0,
            grid=(3.0, 4.0, 5.0, 6.0),
            description="torques are smoothed over 2^smooth ms",
            whole=True,
            as_is=True,
            aside=True,
        ),
    )
    geared, size = "torque", "c"
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

    def aside_columns(self, s: Signals, shape: Shapes) -> Expr:
        within = (shape["v_m"] / SHARPER**k for k in range(3))
        dry, sharp, sharper = (ca.tanh(s.thetad / rate) for rate in within)
        return -ca.vertcat(dry, sharp - dry, sharper - dry, s.thetad)

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        """Where the encoder is taken to be."""
        return "with the encoder at the motor; behind the spring c would be another"


EFFECT = JointElasticity()
