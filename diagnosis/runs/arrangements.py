"""What a log of another order, sign or unit than the base model's might mean."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.kinds import kinds_of

Array = NDArray[np.float64]
THOUSANDS = ((1e-3, "a thousandth"), (1e3, "a thousand times"))
"""Units that are taken for each other."""


@dataclass(frozen=True)
class Seen:
    """Smoothed motion and torque (samples, n) of a run at some instants; payload [kg]; gravity (3,)
    [m/s2], where it is another than that of the base model."""

    theta: Array
    thetad: Array
    thetadd: Array
    tau: Array
    payload: float
    gravity: Array | None = None


@dataclass(frozen=True)
class Arrangement:
    """What the log might mean: column of each axis' angle, and of its torque; factors of both;
    what is added to the angles [rad]; sized: whether it is a size of torques alone; gravity (3,)
    [m/s2], if it is that which is another."""

    text: str
    order: tuple[int, ...]
    angle: Array
    torque: Array
    efforts: tuple[int, ...] = ()
    zero: Array | float = 0.0
    sized: bool = False
    gravity: Array | None = None

    def of(self, seen: Seen) -> Seen:
        """The run as it would be then."""
        order, efforts = list(self.order), list(self.efforts or self.order)
        q, v, a = (x[:, order] * self.angle for x in (seen.theta, seen.thetad, seen.thetadd))
        tau, gravity = seen.tau[:, efforts] * self.torque, self.gravity
        gravity = seen.gravity if gravity is None else gravity
        return Seen(q + self.zero, v, a, tau, seen.payload, gravity)


def zeros(base: Base) -> Iterator[Arrangement]:
    """Angles with another zero, which looks much like a spring that the model lacks."""
    same, ones = tuple(range(base.n)), np.ones(base.n)
    for i, kind in enumerate(kinds_of(base, base.n)):
        for quarter in (1, 2, 3) if kind.turns else ():
            zero = np.where(np.arange(base.n) == i, quarter * np.pi / 2, 0.0)
            moved = f"{90 * quarter} degrees added to" if quarter < 3 else "90 degrees taken from"
            text = f"{moved} the {kind.position} of axis {i + 1}"
            yield Arrangement(text, same, ones, ones, (), zero)


def turned(base: Base, axis: int) -> Arrangement:
    """Angle and torque of an axis (from 0) negated."""
    kind, sign = kinds_of(base, base.n)[axis], np.where(np.arange(base.n) == axis, -1.0, 1.0)
    text = f"{kind.position} and {kind.effort} of axis {axis + 1} negated"
    return Arrangement(text, tuple(range(base.n)), sign, sign)


def arrangements(base: Base) -> Iterator[Arrangement]:
    """Axes exchanged, signs turned, other units."""
    n, kinds = base.n, kinds_of(base, base.n)
    same, ones = tuple(range(n)), np.ones(n)
    for i in range(n):
        sign = np.where(np.arange(n) == i, -1.0, 1.0)
        word, effort = kinds[i].position, kinds[i].effort
        yield Arrangement(f"the {effort} of axis {i + 1} negated", same, ones, sign)
        yield Arrangement(f"the {word} of axis {i + 1} negated", same, sign, ones)
        yield turned(base, i)
        for j in range(i):
            if kinds[i] is kinds[j]:
                swapped = list(same)
                swapped[i], swapped[j] = j, i
                both, of = f"{j + 1} and {i + 1} exchanged", tuple(swapped)
                yield Arrangement(f"axes {both}", of, ones, ones)
                yield Arrangement(f"the {effort}s of axes {both}", same, ones, ones, of)
                yield Arrangement(f"the {word}s of axes {both}", of, ones, ones, same)
        for times, unit in THOUSANDS:
            one = np.where(np.arange(n) == i, times, 1.0)
            yield Arrangement(f"the {effort} of axis {i + 1} of {unit} its size", same, ones, one)
        if kinds[i].turns:
            one = np.where(np.arange(n) == i, np.deg2rad(1.0), 1.0)
            text = f"the {word} of axis {i + 1} taken as degrees, not radians"
            yield Arrangement(text, same, one, ones)
    if len(set(kinds)) == 1 and n > 2:
        yield Arrangement("the axes in reverse order", same[::-1], ones, ones)
        for k in range(1, n):
            order = (*same[k:], *same[:k])
            yield Arrangement(f"axis {k + 1} as the first, the others after it", order, ones, ones)
    yield Arrangement("all torques negated", same, ones, -ones)
    yield Arrangement("all angles and torques negated", same, -ones, -ones)
    for times, unit in THOUSANDS:
        yield Arrangement(f"torques of {unit} their size (units?)", same, ones, times * ones)
    turns = np.array([kind.turns for kind in kinds])
    if turns.any():
        degrees, radians = (np.where(turns, f(ones), 1.0) for f in (np.deg2rad, np.rad2deg))
        yield Arrangement("angles taken as degrees, not radians", same, degrees, ones)
        yield Arrangement("angles taken as radians, not degrees", same, radians, ones)
