"""Dry friction and drag."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
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

PRESLIDING = Shape(
    "s_0",
    "rad",
    low=1e-6,
    high=6e-3,
    start=1e-3,
    grid=(1e-4, 4e-4, 1e-3, 2.5e-3, 5e-3),
    description="angle within which the torque turns over after a reversal",
    blended=True,
)
SMOOTH = Shape(
    "v_0",
    "rad/s",
    low=0.0,
    high=0.2,
    start=0.0,
    grid=(0.0, 0.003, 0.01, 0.03, 0.1),
    description="rate within which the torque turns over, as in a film of grease; 0 where left out",
    optional=True,
)
"""With half of this range or twice as much the names and values of four simulated machines stay as
they are; with half, one of them is taken for Stribeck friction as well."""
STILL = 1e-12
"""Sum of rates [rad/s] at which nothing moves."""
SLOW = Experiment("triangle", {"speed": 0.05, "amplitude": 0.19})


class DryFriction(Effect):
    """Dry friction that turns over within an angle and within a rate.

        z_0' = (thetad g - |thetad| z_0) / s_0,  g = tanh(|thetad| / v_0)

    Presliding alone (v_0 = 0, g = 1) is Dahl's; a lubricated contact, and the friction of most
    simulators, goes with tanh(thetad / v_0) (S. Andersson, A. Soederberg and S. Bjoerklund,
    "Friction models for sliding dry, boundary and mixed lubricated contacts", Tribology
    International 2007).
    """

    states: tuple[State, ...] = (State("z_0", "1"),)
    imitates = "viscous_friction"

    @property
    def grid(self) -> list[dict[str, float]]:
        """Turned over within one of both, and before a Stribeck rate: a contact that is wide in
        both is a hysteresis beside friction."""
        least = PRESLIDING.grid[0]
        pairs = [(own, own["v_0"], own.get("v_s", math.inf)) for own in super().grid]
        return [own for own, v, top in pairs if not v or (own["s_0"] == least and v < top)]

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        level = _level(s, shape) * s.thetad
        return (level - ca.fabs(s.thetad) * state) / shape["s_0"]

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for a step of one sign and one g: its mean along the way."""
        delta = now.theta - before.theta
        level = ca.sign(delta) * _along(before, now, shape, _level)
        return level + (state - level) * ca.exp(-ca.fabs(delta) / shape["s_0"])


class CoulombFriction(DryFriction):
    """F_c z_0: the sign of the motion, after an angle s_0 and beyond a rate v_0.

    Real contacts give way a little before they slide; a wider s_0 is a hysteresis of its own.
    """

    id, title, acts_on = "coulomb_friction", "Coulomb friction", "torque"
    varied = True
    gains = (Gain("F_c", "N m", 0.02, 0.0, 1e5, "friction torque"),)
    shapes = (PRESLIDING, SMOOTH)
    excites = "reversals of the motion at several angles; constant speeds between them"
    confused_with = ("stribeck_friction", "load_friction", "second_hysteresis")
    experiment = "slow triangle: long stretches of one speed, sharp reversals"
    spec = SLOW

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return state


class StribeckFriction(DryFriction):
    """F_c z_0 + F_s z_s: friction that is larger when slow, z_s follows exp(-(thetad / v_s)^2) z_0.

    A contact with a breakaway torque has a friction torque too, so both are one effect; without
    F_s it is Coulomb's. Static friction is some 1.5 times as large (C. Canudas de Wit et al., "A
    new model for control of systems with friction", IEEE TAC 1995), not beyond thrice. Contacts
    remember: z_s follows within the angle s_0, like z_0. To first order in F_s / F_c that is the
    bristle z' = (thetad - |thetad| z / g) / s_0 with g = 1 + (F_s / F_c) exp(-(thetad / v_s)^2),
    LuGre's.
    """

    id, title, acts_on = "stribeck_friction", "Stribeck friction", "torque"
    varied = True
    gains = (
        Gain("F_c", "N m", 0.02, 0.0, 1e5, "friction torque when fast"),
        Gain("F_s", "N m", 0.02, 0.0, 1e5, "breakaway torque less F_c", below=("F_c", 2.0)),
    )
    shapes = (
        PRESLIDING,
        Shape(
            "v_s",
            "rad/s",
            low=1e-3,
            high=0.35,
            start=0.05,
            grid=(0.01, 0.03, 0.1, 0.3),
            description="Stribeck rate, below the usual one",
            closed=True,
        ),
        SMOOTH,
    )
    states = (State("z_0", "1"), State("z_s", "1"))
    excites = "very slow motion beside fast motion"
    confused_with = ("coulomb_friction", "second_hysteresis")
    extends = "coulomb_friction"
    experiment = "triangles below and above the Stribeck rate"
    spec = Experiment("triangle", {"speed": 0.02, "amplitude": 0.1})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return state

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        way = ca.fabs(s.thetad) / shape["s_0"]
        z_s = way * (_slow(s, shape) * state[0] - state[1])
        return ca.vertcat(super().rate(s, state[0], shape), z_s)

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """Exact for a step of one sign, one g and one peak: their means along the way."""
        delta = now.theta - before.theta
        way = ca.fabs(delta) / shape["s_0"]
        level = ca.sign(delta) * _along(before, now, shape, _level)
        peak, left = _along(before, now, shape, _slow), ca.exp(-way)
        z_s = (state[1] + peak * (state[0] - level) * way) * left + peak * level * (1 - left)
        return ca.vertcat(super().advance(before, now, state[0], shape, Ts), z_s)

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        return f"breakaway at {values['F_c'] + values['F_s']:.3g} {units['F_s']}"


def _slow(s: Signals, shape: Shapes) -> Expr:
    """How slow it moves, from 1 at rest to 0."""
    return ca.exp(-((s.thetad / shape["v_s"]) ** 2))


def _level(s: Signals, shape: Shapes) -> Expr:
    """Share of its torque that dry friction has at a rate, 1 where that is beyond v_0."""
    return ca.tanh(ca.fabs(s.thetad) / ca.fmax(shape["v_0"], STILL))


def _along(
    before: Signals, now: Signals, shape: Shapes, of: Callable[[Signals, Shapes], Expr]
) -> Expr:
    """Mean of a function of the rate along the way of a step (Simpson)."""
    seen = (before, 1), (before.towards(now, 0.5), 4), (now, 1)
    weights = [weight * ca.fabs(s.thetad) for s, weight in seen]
    total = sum(w * of(s, shape) for w, (s, _) in zip(weights, seen, strict=True))
    return total / ca.fmax(sum(weights), STILL)


class LoadFriction(DryFriction):
    """mu |tau| z_0: friction of loaded teeth, which grows with the torque that they pass on.

    A gear has it beside Coulomb friction, which is an effect of its own; z_0 is the same.
    P. Hamon, M. Gautier and P. Garrec, "Dynamic identification of robots with a dry friction model
    depending on load and velocity", IROS 2010.
    """

    id, title, acts_on = "load_friction", "load-dependent friction", "drive"
    gains = (Gain("mu", "1", 0.01, 0.0, 0.5, "friction torque per torque"),)
    shapes = (PRESLIDING, SMOOTH)
    excites = "reversals under loads that differ: other angles, another payload"
    confused_with = ("coulomb_friction",)
    experiment = "slow triangle with and without payload"
    spec = replace(SLOW, payload=((0.0, 0.0), (25.0, 1.0)))

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return ca.fabs(s.tau) * state


class QuadraticDrag(Effect):
    """D_2 thetad |thetad|: drag of the air or of a churning fluid."""

    id, title, acts_on = "quadratic_drag", "quadratic drag", "torque"
    gains = (Gain("D_2", "N m s2/rad2", 0.005, 0.0, 1e5, "drag"),)
    excites = "fast moves of different speeds"
    confused_with = ("coulomb_friction", "torque_constant_saturation")
    experiment = "random setpoints, the faster the better"
    spec = Experiment("random", {"period": 0.7, "move": 0.4})

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.thetad * ca.fabs(s.thetad)


EFFECTS = (CoulombFriction(), StribeckFriction(), LoadFriction(), QuadraticDrag())
