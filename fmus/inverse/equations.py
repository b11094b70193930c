"""Torque of a wanted motion from an identified model: what the mechanism needs, and friction.

    tau = Y(r, rd, rdd) p + F_c s + d rd + o + sum gain column

The dry friction s turns over with the rate, tanh((rd + T rdd) / v_s), or with the way since the
last reversal, z of Dahl. The columns are those of effects of the library that were found; what they
feel of a torque is that of the mechanism, Y p. Parameters are inputs of the functions, so that an
importer can tune them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Signals

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
class Term:
    """An effect on an axis, from 0; gains, shapes: places among the parameters."""

    effect: Effect
    axis: int
    gains: tuple[int, ...]
    shapes: Mapping[str, int]


@dataclass(frozen=True)
class Identified:
    """A model of n axes: units of their positions and of their torques, the torque of the
    mechanism, its parameters with those of friction and effects, and where these stand."""

    positions: tuple[str, ...]
    efforts: tuple[str, ...]
    torque: Torque
    parameters: tuple[Parameter, ...]
    friction: tuple[Friction, ...]
    effects: tuple[Term, ...] = ()

    @property
    def n(self) -> int:
        """Axes."""
        return len(self.positions)

    @property
    def n_states(self) -> int:
        """States of the effects; one that stays zero where there are none."""
        return max(1, sum(len(term.effect.states) for term in self.effects))


def functions(model: Identified) -> list[ca.Function]:
    """inverse_presliding(r, before, z, p) -> z of the next sample
    inverse_start(r, p) -> state of the effects at rest
    inverse_follow(before, before_d, before_dd, r, rd, rdd, state, p, Ts) -> state of this sample
    inverse_torque(r, rd, rdd, z, state, p) -> tau_ff
    """
    n = model.n
    r, rd, rdd, before, z = (ca.SX.sym(name, n) for name in ("r", "rd", "rdd", "before", "z"))
    p, state = ca.SX.sym("p", len(model.parameters)), ca.SX.sym("state", model.n_states)
    before_d, before_dd, Ts = ca.SX.sym("before_d", n), ca.SX.sym("before_dd", n), ca.SX.sym("Ts")
    mechanism = model.torque(r, rd, rdd, p)
    rubbed = [dry(model.friction[i], rd[i], rdd[i], z[i], p) for i in range(n)]
    tau = mechanism + ca.vertcat(
        *(_beside(own, rd[i], rubbed[i], p) for i, own in enumerate(model.friction))
    )
    now = signals(r, rd, rdd, mechanism)
    last = signals(before, before_d, before_dd, model.torque(before, before_d, before_dd, p))
    tau += added(model, now, state, p)
    moved = [presliding(own, r[i] - before[i], z[i], p) for i, own in enumerate(model.friction)]
    follow = [before, before_d, before_dd, r, rd, rdd, state, p, Ts]
    listed: list[tuple[str, list[ca.SX], ca.SX, str]] = [
        ("inverse_presliding", [r, before, z, p], ca.vertcat(*moved), "z_next"),
        ("inverse_start", [r, p], start(model, r, p), "state"),
        ("inverse_follow", follow, followed(model, last, now, state, p, Ts), "state_next"),
        ("inverse_torque", [r, rd, rdd, z, state, p], tau, "tau_ff"),
    ]
    return [
        ca.Function(name, inputs, [ca.cse(out)], [_named(v) for v in inputs], [said])
        for name, inputs, out, said in listed
    ]


def _named(symbol: ca.SX) -> str:
    """The name of a vector of symbols: `r` of `r_0`, `r_1`."""
    name = str(symbol[0].name())
    return name if symbol.numel() == 1 else name.rpartition("_")[0]


def signals(r: ca.SX, rd: ca.SX, rdd: ca.SX, tau: ca.SX) -> list[Signals]:
    """What each axis does; no effect here asks for the rate of its torque, or for the time."""
    zero = ca.SX(0)
    each = [Signals(r[i], rd[i], rdd[i], tau[i], zero, zero) for i in range(r.numel())]
    return [replace(own, others=tuple(each)) for own in each]


def _own(model: Identified, state: ca.SX, p: ca.SX) -> list[tuple[Term, ca.SX, dict[str, ca.SX]]]:
    """Each effect with its states and shapes."""
    slices, first = [], 0
    for term in model.effects:
        size = len(term.effect.states)
        shape = {name: p[place] for name, place in term.shapes.items()}
        slices.append((term, state[first : first + size], shape))
        first += size
    return slices


def added(model: Identified, now: list[Signals], state: ca.SX, p: ca.SX) -> ca.SX:
    """Torques (n,) of the effects."""
    tau = ca.SX.zeros(model.n)
    for term, own, shape in _own(model, state, p):
        column = term.effect.columns(now[term.axis], own, shape)
        tau[term.axis] += ca.dot(p[list(term.gains)], column)
    return tau


def start(model: Identified, r: ca.SX, p: ca.SX) -> ca.SX:
    """States of the effects at rest."""
    states = [
        term.effect.start(Signals.resting(r[term.axis]), shape)
        for term, own, shape in _own(model, ca.SX.zeros(model.n_states), p)
        if own.numel()
    ]
    return ca.vertcat(*states) if states else ca.SX.zeros(1)


def followed(
    model: Identified, last: list[Signals], now: list[Signals], state: ca.SX, p: ca.SX, Ts: ca.SX
) -> ca.SX:
    """States of the effects Ts later."""
    states = [
        term.effect.advance(last[term.axis], now[term.axis], own, shape, Ts)
        for term, own, shape in _own(model, state, p)
        if own.numel()
    ]
    return ca.vertcat(*states) if states else state


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
