"""Drives that give less at high torque than they report."""

from __future__ import annotations

import casadi as ca

from fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shape, Shapes, Signals

BRISK = Experiment("random", {"period": 0.7, "move": 0.35}, ((0.0, 0.0), (25.0, 2.0)))

GRID = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Limits to try [N m]."""


class TorqueConstantSaturation(Effect):
    """s tau max(0, |tau| - tau_k): the iron saturates, torque lags behind the current."""

    id, title, acts_on = "torque_constant_saturation", "saturation of the torque constant", "drive"
    gains = (Gain("s", "1/N m", 0.005, 0.0, 0.1, "relative loss per torque beyond tau_k"),)
    shapes = (Shape("tau_k", "N m", 0.0, 50.0, 2.0, (0.0, 1.0, 2.0, 4.0), "where it begins"),)
    excites = "high and low torques at the same angles: brisk moves, another payload"
    confused_with = ("drive_gain", "torque_saturation", "quadratic_drag")
    experiment = "brisk random setpoints, with a payload in the second half"
    spec = BRISK

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.tau * ca.fmax(0, ca.fabs(s.tau) - shape["tau_k"])


class TorqueSaturation(Effect):
    """clip (tau - tau / (1 + |tau / tau_lim|^p)^(1/p)): the joint gets no more than tau_lim.

    With clip = 1 the drive gives up all beyond tau_lim, though it reports what it was asked for.
    A large p is a sharp corner, p = 2 an amplifier that gives way gradually (Rapp's model).
    """

    id, title, acts_on = "torque_saturation", "torque limit", "drive"
    gains = (Gain("clip", "1", 1.0, 0.0, 1.0, "share of the excess that is lost"),)
    shapes = (
        Shape("tau_lim", "N m", 0.1, 100.0, 5.0, GRID, "limit"),
        Shape("p", "1", 1.0, 40.0, 16.0, (2.0, 16.0), "sharpness of the corner"),
    )
    reported = True
    excites = "torques beyond the limit"
    confused_with = ("torque_constant_saturation",)
    experiment = "brisk random setpoints, with a payload in the second half"
    spec = BRISK
    feedforward = "a drive at its limit has no more torque to give: slower moves are the cure"

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        p = shape["p"]
        return s.tau * (1 - (1 + ca.fabs(s.tau / shape["tau_lim"]) ** p) ** (-1 / p))


EFFECTS = (TorqueConstantSaturation(), TorqueSaturation())
