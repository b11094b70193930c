"""A second Dahl hysteresis beside the one of the actuator model."""

from __future__ import annotations

from typing import Any

import casadi as ca

from flexhex.fmus.common import actuator
from flexhex.fmus.common.effects.effect import (
    Effect,
    Experiment,
    Expr,
    Gain,
    Shape,
    Shapes,
    Signals,
    State,
)

WIDTHS = (0.002, 0.004, 0.008, 0.03, 0.06, 0.12)
"""Below 6 mrad it may also be dry friction before it slides; then both are named as a set."""


class SecondHysteresis(Effect):
    """c_2 z_2 with z_2' = (thetad - |thetad| z_2) / sigma_2.  [SH, Eq. (23)]"""

    id, title, acts_on = "second_hysteresis", "additional hysteresis", "torque"
    gains = (Gain("c_2", "N m", 0.02, 0.0, 1e5, "height"),)
    shapes = (Shape("sigma_2", "rad", 1.5e-3, 0.5, 0.05, WIDTHS, "width"),)
    states = (State("z_2", "1"),)
    excites = "reversals after long and after short ways"
    confused_with = ("coulomb_friction", "stribeck_friction")
    experiment = "slow triangles of several amplitudes"
    spec = Experiment("triangle", {"speed": 0.05, "amplitude": 0.1})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return state

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return actuator.dahl_rate(state, s.thetad, shape["sigma_2"])

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for a step of one sign, whatever the rate does meanwhile."""
        return actuator.dahl(state, now.theta - before.theta, shape["sigma_2"])


EFFECT = SecondHysteresis()
