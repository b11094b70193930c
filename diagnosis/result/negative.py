"""Friction and inertias that no machine has, said as what they may come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.kinds import Kind, kinds_of
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.diagnosis.runs.blocks import Block

Array = NDArray[np.float64]
DRY = ("F_c", "coulomb_friction")
"""A parameter, and the effect that has it."""
HAVE = ("J", "m", "d", "F_c")
"""Parameters of an axis that no machine has below zero."""


@dataclass(frozen=True)
class Asked:
    """A value that runs alone ask for, with its standard deviation [unit]."""

    name: str
    value: float
    deviation: float
    unit: str

    @property
    def text(self) -> str:
        """`d[1] = -45.6 ± 0.5 N m s/rad`."""
        return f"{self.name} = {self.value:.3g} ± {NORMAL * self.deviation:.2g} {self.unit}"


def below_zero(axis: int, kind: Kind, own: Sequence[Asked], rates: Array, sure: float) -> str:
    """What it means that some of these are `sure` deviations below zero, or nothing; rates
    (samples,) of the axis, from 0."""
    below = [_kind(one.name) for one in own if one.value < -sure * one.deviation]
    if not below:
        return ""
    power = {"d": float((rates**2).mean()), "F_c": float(np.abs(rates).mean())}
    rubs = sum(one.value * power.get(_kind(one.name), 0.0) for one in own)
    inertia = bool(set(below) & {"J", "m"})
    if rubs < 0 or (rubs == 0 and inertia):
        why = (
            f"its {kind.effort} or its {kind.position} has the other sign in the logs, or is"
            " another axis' column. Negate one of the two columns (of currents by a negative"
            " --torque-constant), or name the right one"
        )
    elif inertia:
        why = (
            f"its {kind.effort} and its {kind.position} are of other times, something elastic"
            " swings in between, or noise of the acceleration is larger than it"
        )
    elif below == ["F_c"]:
        why = (
            f"friction grows faster than the rate, as drag does, or the {kind.effort} lags by"
            " another time than the delay that is fitted"
        )
    else:
        why = (
            f"friction falls with the rate (Stribeck friction), or {kind.effort} and"
            f" {kind.position} are of other axes, signs or times: check the columns"
        )
    values = " and ".join(one.text for one in own if _kind(one.name) in {*below, "d", "F_c"})
    return f"axis {axis + 1} comes out with {values}, as no machine has it: {why}"


def negative(fit: Joint, sure: float) -> str:
    """The same of the axes of a base model beside effects that were found; nothing where all is as
    a machine has it."""
    model, texts = fit.bench.model, list[str]()
    deviation = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0)) * model.scale
    for i, kind in enumerate(kinds_of(model.base, model.base.n)):
        if not any(block.judged[:, i].any() for block in model.blocks):
            # no row says anything of an axis that rests all the time
            continue
        own = [
            Asked(
                k.name, k.nominal + float(model.scale[p] * fit.q[p]), float(deviation[p]), k.printed
            )
            for p, k in enumerate(model.base.linear)
            if k.axis == i and k.name == f"{_kind(k.name)}[{i + 1}]" and _kind(k.name) in HAVE
        ]
        gains = [
            Asked(f"{DRY[0]}[{i + 1}]", float(beta[0]), float(spread[0]), kind.unit("N m"))
            for part, beta, spread in zip(fit.parts, fit.beta, fit.deviation, strict=True)
            if part.axis == i and part.id == DRY[1]
        ]
        texts.append(below_zero(i, kind, [*own, *gains], rates_of(model.blocks, i), sure))
    return "; ".join(filter(None, texts))


def rates_of(blocks: Sequence[Block], axis: int) -> Array:
    """Rates (samples,) of an axis in all runs."""
    return np.concatenate([b.run.motion.thetad[b.run.valid, axis] for b in blocks])


def _kind(name: str) -> str:
    return name.partition("[")[0]
