"""Drives that give less at high torque than they report."""

from __future__ import annotations

from dataclasses import replace

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

BRISK = Experiment("random", {"period": 0.7, "move": 0.35}, ((0.0, 0.0), (25.0, 2.0)))

SHARP = Shape("p", "1", 1.0, 400.0, 16.0, (2.0, 16.0, 400.0), "sharpness of the corner")
TINY = 1e-12
"""Torque [N m] that a drive at rest divides by."""
GRID = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98)
"""Limits to try, shares of the largest torque: one in its upper half takes little of a torque, and
away from it the excess has another size."""


class TorqueConstantSaturation(Effect):
    """s tau ((|tau|^p + tau_k^p)^(1/p) - tau_k): the iron saturates, torque falls behind current.

    A large p is a corner, s tau max(0, |tau| - tau_k); p = 2 gives way from the start, with the
    cube of the torque at first. With p = 1 it would not matter where it begins.
    """

    id, title, acts_on = "torque_constant_saturation", "saturation of the torque constant", "drive"
    gains = (Gain("s", "1/N m", 0.005, 0.0, 1e4, "relative loss per torque beyond tau_k"),)
    shapes = (
        Shape("tau_k", "N m", 0.0, 1e5, 2.0, (0.0, 1.0, 2.0, 4.0, 8.0), "where it begins"),
        replace(SHARP, low=2.0),
    )
    excites = "high and low torques at the same angles: brisk moves, another payload"
    confused_with = ("drive_gain", "torque_saturation", "quadratic_drag")
    experiment = "brisk random setpoints, with a payload in the second half"
    spec = BRISK

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        tau, tau_k, p = ca.fabs(s.tau), shape["tau_k"], shape["p"]
        larger, smaller = ca.fmax(tau, tau_k), ca.fmin(tau, tau_k)
        return s.tau * (larger * (1 + (smaller / (larger + TINY)) ** p) ** (1 / p) - tau_k)


class TorqueSaturation(Effect):
    """clip (tau - tau / (1 + |tau / tau_lim|^p)^(1/p)): the joint gets no more than tau_lim.

    With clip = 1 the drive gives up all beyond tau_lim, though it reports the command.
    A large p is a sharp corner, p = 2 an amplifier that gives way gradually (Rapp's model). Where
    the command is known an amplifier shows between it and the report, and what gives way
    gradually behind the report is the motor's iron.
    """

    id, title, acts_on = "torque_saturation", "torque limit", "drive"
    gains = (Gain("clip", "1", 1.0, 0.0, 1.0, "share of the excess that is lost", full=True),)
    shapes = (
        Shape("tau_lim", "N m", 1e-4, 1e5, 0.8, GRID, "limit", of_peak=True),
        SHARP,
    )
    reported, size = True, "tau_lim"
    excites = "torques beyond the limit"
    confused_with = ("torque_constant_saturation",)
    experiment = "brisk random setpoints, with a payload in the second half"
    spec = BRISK
    feedforward = "a drive at its limit has no more torque to give: slower moves are the cure"

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        x, p = ca.fabs(s.tau) / shape["tau_lim"], shape["p"]
        larger, smaller = ca.fmax(x, 1), ca.fmin(x, 1)
        return s.tau * (1 - (1 + (smaller / larger) ** p) ** (-1 / p) / larger)


class SharpTorqueSaturation(TorqueSaturation):
    """A limit with a corner, which takes away nearly all that goes beyond it."""

    behind, entered = None, True
    gains = (replace(TorqueSaturation.gains[0], low=0.9),)
    shapes = (TorqueSaturation.shapes[0], replace(SHARP, grid=(400.0,)))


TorqueSaturation.behind = SharpTorqueSaturation()

EFFECTS = (TorqueConstantSaturation(), TorqueSaturation())
