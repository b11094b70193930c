"""How large an effect is, and what repeats that nothing explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.regression import Regression
from flexhex.diagnosis.scored import Scored

Array = NDArray[np.float64]

LEAST_SHARE, LEAST_FIRST = 0.12, 0.04
"""Share of what repeats on its axis that an effect must explain on trajectories left out: of what
is left in its round, and of what was there at first."""
SMALLEST = 0.0015
"""Smallest effect that is worth naming, RMS relative to the torque's."""
LEAST_KIN = 0.5
"""The same of what is left, beside an effect with which the library confuses it."""


def unexplained(made: Calibrated, regression: Regression) -> Array:
    """What repeats (n,), and by how much the parameters had to leave their tolerances for it."""
    return repeating(made, regression.residual) + regression.strain


def repeating(made: Calibrated, residual: Array) -> Array:
    """Sum of squares of what repeats of a whitened residual (R,), for each axis (n,).

    Without repeats the sum of all squares, an upper bound.
    """
    products = (made.layout.twin(residual) if made.between else residual) * residual
    total = [products[made.layout.rows(i)].sum() for i in range(made.base.n)]
    return np.asarray(np.maximum(np.array(total), 0.0))


def worth(bench: Bench, energy: Array, axis: int | None) -> bool:
    """Whether what repeats on an axis could hold an effect that is large enough."""
    rows = len(bench.made.regression.y) / bench.n
    size = np.sqrt(energy / rows) * _unit(bench.made)
    large = size > SMALLEST * bench.made.torque_rms
    return bool(large.any() if axis is None else large[axis])


def _unit(made: Calibrated) -> Array:
    """Torque (n,) [N m] that a whitened one stands for: the noise's own.

    Where products are not taken between passes noise is among them, and only what stands out of
    its innovations counts.
    """
    return made.noise.floor if made.between else made.noise.scale


def is_large(
    bench: Bench,
    regression: Regression,
    part: Scored,
    energy: Array,
    first: Array,
    known: Sequence[Scored],
) -> bool:
    """Whether an effect on an axis is large enough to be named.

    What the library confuses with an effect already found there must explain most of what is
    left: else it makes up for a form that nature does not quite have.
    """
    made = bench.made
    axes = list(range(bench.n)) if part.axis is None else [part.axis]
    rows = len(made.regression.y) / bench.n * len(axes)
    least, gained = SMALLEST * float(made.torque_rms[axes].mean()), max(part.gain.outside, 0.0)
    if not made.between:  # the noise itself is among what is left, and what is slow is whitened
        return gained > 0 and torque_of(bench, regression, part) > least
    size = np.sqrt(gained / rows) * float(_unit(made)[axes].mean())
    if size < least and part.axis is not None and gained > 0:
        # what is slow is larger than it seems among whitened rows
        size = torque_of(bench, regression, part)
    if size < least:
        return False
    least = LEAST_KIN if any(_kin(bench, part, other) for other in known) else LEAST_SHARE
    shares = least * energy[axes].sum(), LEAST_FIRST * first[axes].sum()
    return bool(gained > max(shares))


def torque_of(bench: Bench, regression: Regression, part: Scored) -> float:
    """RMS [N m] of an effect on an axis (None: on all), without what the base model takes on in its
    fit. An encoder's error on one axis makes torques on all: they count together."""
    made, C, own = bench.made, part.columns, part.axis
    moved = regression.solve(regression.products(C.axis, C.values)[1]) @ part.gain.beta
    taken = moved[: len(made.known)]
    rows = slice(None) if C.axis is None else C.axis
    thin = bench.thin(part.id, own or 0, part.shape)
    left = np.concatenate(
        [
            values[kept] @ part.gain.beta - B[kept][:, rows] @ taken
            for values, B, kept in zip(thin, made.B, made.kept, strict=True)
        ]
    )
    return float(np.sqrt((left**2).sum() / (len(left) * (bench.n if own is None else 1))))


def _kin(bench: Bench, part: Scored, other: Scored) -> bool:
    """Whether two effects on an axis are another, and confused by their own definitions."""
    mine, its = bench.effects.get(part.id), bench.effects.get(other.id)
    if mine is None or its is None or part.axis != other.axis or part.id == other.id:
        return False
    return other.id in mine.effect.confused_with or part.id in its.effect.confused_with
