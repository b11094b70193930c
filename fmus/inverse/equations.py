"""Torque of a wanted motion from an identified model: what the mechanism needs, and friction.

    tau = Y(r, rd, rdd) p + F_c s + d rd + o

The dry friction s turns over with the rate, tanh((rd + T rdd) / v_s), or with the way since the
last reversal, z of Dahl. Parameters are inputs of the functions, so that an importer can tune them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca

Torque = Callable[[ca.SX, ca.SX, ca.SX, ca.SX], ca.SX]
"""Torques (n,) of a mechanism from theta, thetad, thetadd (n,) and its parameters."""


@dataclass(frozen=True)
class Parameter:
    """A number of the model: name, unit, identified value [unit]."""

    name: str
    unit: str
    value: float


@dataclass(frozen=True)
class Friction:
    """Of one axis, by places among the parameters, None where the model has none of it.

    dry F_c, viscous d, offset o; form: what the dry friction turns over with; size: place of v_s
    or s_0; lead: place of T.
    """

    dry: int | None
    viscous: int | None
    offset: int | None
    form: Literal["rate", "way"]
    size: int | None
    lead: int | None


@dataclass(frozen=True)
class Identified:
    """A model of n axes: units of their positions and of their torques, the torque of the
    mechanism, its parameters with those of friction, and where these stand."""

    positions: tuple[str, ...]
    efforts: tuple[str, ...]
    torque: Torque
    parameters: tuple[Parameter, ...]
    friction: tuple[Friction, ...]

    @property
    def n(self) -> int:
        """Axes."""
        return len(self.positions)


def functions(model: Identified) -> list[ca.Function]:
    """inverse_presliding(r, before, z, p) -> z of the next sample
    inverse_torque(r, rd, rdd, z, p) -> tau_ff
    """
    n = model.n
    r, rd, rdd, before, z = (ca.SX.sym(name, n) for name in ("r", "rd", "rdd", "before", "z"))
    p = ca.SX.sym("p", len(model.parameters))
    rubbed = [dry(model.friction[i], rd[i], rdd[i], z[i], p) for i in range(n)]
    tau = model.torque(r, rd, rdd, p) + ca.vertcat(
        *(_beside(own, rd[i], rubbed[i], p) for i, own in enumerate(model.friction))
    )
    moved = [presliding(own, r[i] - before[i], z[i], p) for i, own in enumerate(model.friction)]
    return [
        ca.Function(
            "inverse_presliding",
            [r, before, z, p],
            [ca.vertcat(*moved)],
            ["r", "before", "z", "p"],
            ["z_next"],
        ),
        ca.Function(
            "inverse_torque",
            [r, rd, rdd, z, p],
            ca.cse([tau]),
            ["r", "rd", "rdd", "z", "p"],
            ["tau_ff"],
        ),
    ]


def dry(own: Friction, rate: ca.SX, acceleration: ca.SX, z: ca.SX, p: ca.SX) -> ca.SX:
    """Share s of the dry friction, -1 to 1."""
    if own.form == "way" or own.size is None:
        return z
    lead = 0 if own.lead is None else p[own.lead]
    return ca.tanh((rate + lead * acceleration) / p[own.size])


def presliding(own: Friction, step: ca.SX, z: ca.SX, p: ca.SX) -> ca.SX:
    """z after a step [rad, m] of one sign: z' = (rd - |rd| z) / s_0, exactly.  [Dahl 1968]"""
    if own.form != "way" or own.size is None:
        return ca.SX(0)
    left = ca.exp(-ca.fabs(step) / p[own.size])
    return left * z + ca.sign(step) * (1 - left)


def _beside(own: Friction, rate: ca.SX, s: ca.SX, p: ca.SX) -> ca.SX:
    terms: Sequence[tuple[int | None, ca.SX]] = (
        (own.dry, s),
        (own.viscous, rate),
        (own.offset, ca.SX(1)),
    )
    return sum((p[place] * by for place, by in terms if place is not None), ca.SX(0))
