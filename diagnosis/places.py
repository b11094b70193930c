"""A torque at one place of the stroke: it has no name, but harmonics and springs can follow it.

A dent, a snag or a knock acts at some angles only. Enough harmonics add up to it, each passing its
own test. So what acts through the angle alone is held against one bump with a place and a width:
where that does as well with less to choose from, nothing is named there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.compiled import N_SIGNAL, Compiled, compiled, signals
from flexhex.diagnosis.rivals import NEAR
from flexhex.diagnosis.scored import Found, Scored, leaders
from flexhex.fmus.common.effects import Effect, Experiment, Expr, Gain, Shape, Shapes, Signals

BETTER = 1.25
"""What a bump must gain, relative to parts that have no more to choose from than it has."""
PLACES, WIDTHS = 25, (0.04, 0.08, 0.16)
"""Grid over the stroke; half widths relative to it."""


class Bump(Effect):
    """(1 - u2)2 for u = (theta - place) / width within 1: smooth, and nothing elsewhere."""

    id, title, acts_on = "bump", "torque at one place", "torque"
    gains = (Gain("height", "N m", 0.004, -10.0, 10.0, "torque in the middle"),)
    excites = "the whole stroke, slowly"
    confused_with = ("cogging_harmonic",)
    experiment = "slow triangle through the place"
    spec = Experiment("triangle")

    def __init__(self, low: float, high: float) -> None:
        """low, high: the stroke [rad], in the sizes of the library where the axis slides."""
        stroke = high - low
        grid = tuple(float(v) for v in np.linspace(low, high, PLACES + 2)[1:-1])
        widths = tuple(stroke * w for w in WIDTHS)
        self.shapes = (
            Shape("place", "rad", low, high, grid[PLACES // 2], grid, "where it acts"),
            Shape("width", "rad", widths[0] / 4, widths[-1], widths[1], widths, "half its width"),
        )

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        u = (s.theta - shape["place"]) / shape["width"]
        return ca.fmax(1 - u**2, 0) ** 2


def without_places(bench: Bench, found: Sequence[Found], notes: list[str]) -> list[Found]:
    """Effects but those on axes where one bump explains what several parts follow."""
    bumped = set()
    for axis in sorted({axis for effect in found for axis in effect.axes}):
        parts = [part for effect in found for part in effect.parts if part.axis == axis]
        curves = [part for part in parts if _is_curve(bench.effects[part.id])]
        if not curves:
            continue
        bump = _bump(bench, axis, [part for part in parts if part not in curves])
        freedom = sum(bench.effects[part.id].freedom for part in curves)
        gained = sum(part.gain.outside for part in curves)
        if bump is not None and bump.gain.outside > _needed(gained, freedom):
            bumped.add(axis)
            names = ", ".join(dict.fromkeys(part.id for part in curves))
            kind = bench.scales.kinds[axis]
            place = f"{bump.shape['place']:.3g} {kind.unit('rad')}"
            where = f"near {place} on axis {axis + 1}"
            notes.append(
                f"a {kind.effort} {where} alone explains as much as {names}: the library has no"
                " effect of that kind"
            )
    kept = [
        replace(
            effect,
            parts=tuple(
                part
                for part in effect.parts
                if part.axis not in bumped or not _is_curve(bench.effects[part.id])
            ),
        )
        for effect in found
    ]
    return [effect for effect in kept if effect.parts]


def _needed(gained: float, freedom: int) -> float:
    """What a bump, three numbers, must gain to stand for parts of that freedom."""
    return gained * (NEAR if freedom > 3 else BETTER)


def _bump(bench: Bench, axis: int, others: Sequence[Scored]) -> Scored | None:
    """The best bump on an axis beside what else was found there."""
    made = bench.made
    angles = np.concatenate([block.run.motion.theta[:, axis] for block in made.blocks])
    size = bench.scales.scale("rad", axis)
    shape = Bump(float(angles.min()) / size, float(angles.max()) / size)
    regression = made.regression
    if others:
        regression = regression.extended([part.columns for part in others])
    alone = Bench(made, compiled(made.base.n, {shape.id: shape}))
    best = leaders(alone, regression, axis)
    return best[0] if best else None


def _is_curve(item: Compiled) -> bool:
    """Whether an effect's columns follow the angle of its axis alone."""
    if item.effect.states or item.effect.acts_on != "torque":
        return False
    u, shape = ca.SX.sym("u", N_SIGNAL), ca.SX.sym("shape", len(item.effect.shapes))
    named = {s.name: shape[k] for k, s in enumerate(item.effect.shapes)}
    columns = item.effect.columns(signals(0, u), ca.SX.zeros(1), named)
    asked = ca.which_depends(columns, u)
    return bool(item.alone and asked[0] and not any(asked[1:]))
