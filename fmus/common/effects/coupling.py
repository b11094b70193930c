"""A torque that comes from what another axis does."""

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

KINDS = ("angle", "rate", "acceleration", "torque")


class CrossCoupling(Effect):
    """C u, u = theta, thetad, thetadd or tau of the axis `source`, in SI units.

    kind: 0 angle (cable between axes), 1 rate, 2 acceleration (shared inertia), 3 torque
    (crosstalk of drives).
    """

    id, title, acts_on = "cross_coupling", "coupling with another axis", "torque"
    gains = (Gain("C", "N m", 0.005, -1e5, 1e5, "torque per SI unit of the source's motion"),)
    shapes = (
        Shape(
            "source",
            "1",
            1.0,
            6.0,
            1.0,
            (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            "axis",
            whole=True,
            words=tuple(f"axis {k}" for k in range(1, 7)),
        ),
        Shape(
            "kind",
            "1",
            0.0,
            3.0,
            3.0,
            (0.0, 1.0, 2.0, 3.0),
            "0: its angle, 1: rate, 2: acceleration, 3: torque",
            whole=True,
            words=KINDS,
        ),
    )
    most = 6
    excites = "each axis moving alone while the others hold"
    confused_with = ("drive_gain",)
    experiment = "multisines, the axes one after the other"
    spec = Experiment("multisine", {"amplitude": 0.05, "f_base": 0.1, "n_sines": 16.0})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        source, kind = ca.SX(shape["source"]), ca.SX(shape["kind"])
        total = ca.SX(0)
        for k, axis in enumerate(s.others, start=1):
            motion = (axis.theta, axis.thetad, axis.thetadd, axis.tau)
            for m, value in enumerate(motion):
                total += (source == k) * (kind == m) * value
        return total

    def meets(self, axis: int, n: int, shape: Mapping[str, float]) -> bool:
        """An axis that acts on itself is no coupling, but friction, stiffness, inertia or gain."""
        return shape["source"] != axis and shape["source"] <= n

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        """What of which axis makes it."""
        if not {"source", "kind"} <= values.keys():
            return ""
        source, kind = (s.said(values[s.name]) for s in self.shapes)
        return f"per SI unit of the {kind} of {source}"


EFFECT = CrossCoupling()
