"""A flexible mode: part of what a joint carries swings on it."""

from __future__ import annotations

from typing import Any

import casadi as ca

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

FREQUENCIES = tuple(round(4.0 * 1.07**k, 3) for k in range(-30, 47))
"""A mode is as wide as twice its damping; finer steps are the search's."""


STRONG = 0.3
"""Damping ratio at which a mode hardly swings any more: then it is a lag."""


class FlexibleMode(Effect):
    """J_2 (q'' - thetadd) with q'' = w^2 (theta - q) + 2 zeta w (thetad - q'), w = 2 pi f.

    J_2 is a part of the inertia that the model has already: what stood still against the joint
    swings. A mass that was added is another inertia beside it.
    """

    id, title, acts_on = "flexible_mode", "flexible mode", "torque"
    gains = (Gain("J_2", "kg m2", 5e-4, 0.0, 1e4, "inertia that swings"),)
    shapes = (
        Shape("f", "Hz", 0.5, 500.0, 20.0, FREQUENCIES, "mode"),
        Shape("zeta", "1", 1e-3, STRONG, 0.03, (0.02, 0.06, 0.2), "damping ratio", closed=True),
    )
    states = (State("q", "rad"), State("qd", "rad/s"))
    most = 3
    excites = "accelerations about its frequency"
    confused_with = ("drive_lag", "time_delay")
    experiment = "chirp through its frequency"
    spec = Experiment("chirp", {"f0": 1.0, "f1": 40.0, "amplitude": 0.002})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return self._pull(s, state, shape) - s.thetadd

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.vertcat(state[1], self._pull(s, state, shape))

    @staticmethod
    def _pull(s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        w = 2 * ca.pi * shape["f"]
        return w**2 * (s.theta - state[0]) + 2 * shape["zeta"] * w * (s.thetad - state[1])

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for an acceleration of the joint that changes linearly.

        e = q - theta:  e'' + 2 zeta w e' + w^2 e = -(a + j t), solved by its particular
        solution -(a + j t) / w^2 + 2 zeta j / w^3 and a decaying oscillation. What goes with the
        shapes and Ts alone stands together, as it is the same in all steps.
        """
        w, zeta = 2 * ca.pi * shape["f"], shape["zeta"]
        wd = w * ca.sqrt(1 - zeta**2)
        # of a plain 1 / w^2 CasADi would make a division in every step
        decay, soft = ca.exp(-zeta * w * Ts), 0.5 * (2 / w**2)
        along, across = decay * ca.cos(wd * Ts), decay * ca.sin(wd * Ts) / wd
        damped = zeta * w * across
        drift = -(soft / Ts) * (now.thetadd - before.thetadd)
        settled = -soft * before.thetadd - (2 * zeta / w) * drift
        e, ed = state[0] - before.theta - settled, state[1] - before.thetad - drift
        q = now.theta + settled + Ts * drift + (along + damped) * e + across * ed
        rate = (along - damped) * ed - (w**2 * across) * e
        return ca.vertcat(q, now.thetad + drift + rate)

    def start(self, s: Signals, shape: Shapes) -> Expr:
        return ca.vertcat(s.theta - s.thetadd / (2 * ca.pi * shape["f"]) ** 2, s.thetad)


EFFECT = FlexibleMode()
