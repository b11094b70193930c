"""What changes while the machine runs: magnets and windings that warm up, offsets that creep."""

from __future__ import annotations

from collections.abc import Mapping
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

GRID = (20.0, 60.0, 200.0, 600.0, 2000.0)
TIME = Shape("T", "s", 1.0, 1e5, 600.0, GRID, "thermal time constant", of_time=True)
LONG = Experiment("random", {"duration": 50.0, "passes": 12.0})


class ThermalDrift(Effect):
    """(g_t (1 - exp(-t / T)) + g_w w) tau: warm magnets give less torque per current.

    g_t counts the time since the start of the run; g_w the losses, w' = (tau^2 - w) / T. Neither
    is negative: no magnet gets stronger when it warms up.
    """

    id, title, acts_on = "thermal_drift", "thermal drift of the motor constant", "drive"
    gains = (
        Gain("g_t", "1", 0.01, 0.0, 0.5, "relative loss after a long time"),
        Gain("g_w", "1/N2 m2", 1e-3, 0.0, 1e6, "relative loss per mean square of the torque"),
    )
    shapes = (TIME,)
    limit = "drive_gain"
    states = (State("w", "N2 m2"),)
    excites = "a run as long as the time constant, from cold"
    confused_with = ("offset_drift", "drive_gain")
    experiment = "random setpoints, the same trajectory many times over from a cold start"
    spec = LONG

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.vertcat(s.tau * (1 - ca.exp(-s.time / shape["T"])), s.tau * state)

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return (s.tau**2 - state) / shape["T"]

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for a torque that is square-mean constant over the step."""
        tau2 = (before.tau**2 + before.tau * now.tau + now.tau**2) / 3
        return tau2 + (state - tau2) * ca.exp(-Ts / shape["T"])

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        long, loaded = (100 * values[name] for name in ("g_t", "g_w"))
        square = units["g_w"].partition("/")[2]
        losses = [f"{long:.2g} % after a long time"] if long else []
        losses += [f"{loaded:.2g} % for each {square} of mean square torque"] if loaded else []
        return f"loses {' and '.join(losses)}" if losses else ""


class OffsetDrift(Effect):
    """o_r T (1 - exp(-t / T)): a torque that creeps in, and comes to rest after some T.

    The gain is the initial creep rate, which also a run shorter than T determines.
    """

    id, title, acts_on = "offset_drift", "drift of the offset", "torque"
    gains = (Gain("o_r", "N m/s", 1e-3, -1e3, 1e3, "creep at first"),)
    shapes = (TIME,)
    limit = "torque_offset"
    usual = 0.01
    excites = "a run as long as the time constant"
    confused_with = ("thermal_drift",)
    experiment = "random setpoints, the same trajectory many times over from a cold start"
    spec = LONG

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return shape["T"] * (1 - ca.exp(-s.time / shape["T"]))


EFFECTS = (ThermalDrift(), OffsetDrift())
