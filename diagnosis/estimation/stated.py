"""Effects that a model's file states, in an identification: their gains are fitted anew with all
other parameters, friction and offset in the form that the runs show, others in the file's shape."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.jointfit.known import known_torque
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.nominal import SURE
from flexhex.fmus.common.effects import Effect

Array = NDArray[np.float64]
SAME = 1e-3
"""Relative difference of two shapes that are one: a number that was rounded by hand."""


@dataclass(frozen=True)
class Told:
    """An effect that a file states on an axis, from 1; number: which of several there."""

    effect: Effect
    axis: int
    shape: Mapping[str, float]
    gains: tuple[float, ...]
    number: int

    @property
    def extra(self) -> Extra:
        """As it is fitted beside."""
        return Extra(self.effect, self.axis - 1, dict(self.shape), self.number, self.gains)

    @property
    def named(self) -> dict[str, float]:
        """Its gains by the names of an identification's parameters."""
        if self.effect.id in PARAMETER:
            return {f"{PARAMETER[self.effect.id]}[{self.axis}]": self.gains[0]}
        names = [self.extra.parameter(gain.name) for gain in self.effect.gains]
        return dict(zip(names, self.gains, strict=True))


def stated_of(base: Base) -> list[Told]:
    """Those of a base model."""
    listed, counts = list[Told](), Counter[tuple[str, int]]()
    for use in base.stated.uses:
        for axis, gains in zip(use.axes, zip(*use.gains, strict=True), strict=True):
            counts[use.id, axis] += 1
            listed.append(Told(use.effect, axis, use.shape, gains, counts[use.id, axis]))
    return listed


def with_stated(base: Base, more: Extras) -> Extras:
    """Effects that are fitted beside: those of the file that no parameter of friction is, and the
    others."""
    stated = stated_of(base)
    if not stated:
        return more
    own = [told.extra for told in stated if told.effect.id not in PARAMETER]
    listed, rest = list[Extra](), list(more.listed)
    for one in own:
        same = next((other for other in rest if _same(one, other)), None)
        if same is not None:
            rest.remove(same)
        # of how sure its shape is the diagnosis knows
        listed.append(one if same is None else replace(same, number=one.number))
    counts = Counter((one.effect.id, one.axis) for one in listed)
    for one in rest:
        counts[one.effect.id, one.axis] += 1
        listed.append(replace(one, number=counts[one.effect.id, one.axis]))
    written = {name: value for told in stated for name, value in told.named.items()}
    changed = tuple(change for change in more.changed if change.parameter not in written)
    return replace(
        more, listed=tuple(listed), changed=changed, file=base.stated.uses, written=written
    )


def _same(one: Extra, other: Extra) -> bool:
    """Whether a file and a diagnosis have the same effect."""
    return (one.effect.id, one.axis) == (other.effect.id, other.axis) and all(
        math.isclose(value, other.shape[name], rel_tol=SAME)
        or abs(value - other.shape[name]) < SURE * other.deviation.get(name, 0.0)
        for name, value in one.shape.items()
    )


def file_torque(there: Calibrated, more: Extras) -> Sequence[Array]:
    """Torque (m, n) of each block that they make with the file's values."""
    return known_torque(there, more.file) if more.file else [np.zeros_like(y) for y in there.y]
