"""Viscous friction, for machines whose own model has none; the hexapod's actuators have d."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shapes, Signals


class ViscousFriction(Effect):
    """d_v thetad: bearings in oil, gears, back-emf of a shorted motor."""

    id, title, acts_on = "viscous_friction", "viscous friction", "torque"
    gains = (Gain("d_v", "N m s/rad", 0.02, 0.0, 1e5, "viscous friction"),)
    varied = True
    excites = "moves of different speeds"
    confused_with = ("quadratic_drag", "coulomb_friction")
    experiment = "random setpoints of different speeds, standstill between them"
    spec = Experiment("random", {"period": 1.0, "move": 0.3})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.thetad


EFFECT = ViscousFriction()
