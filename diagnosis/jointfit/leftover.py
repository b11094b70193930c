"""How large the torque is that a fit leaves: all of it, and what of it repeats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.noise import pairs, whitening

Array = NDArray[np.float64]


def repeating(model: Calibrated, residual: Array) -> Array:
    """Sum of squares of what repeats of a whitened residual (R,), for each axis (n,).

    Without repeats the sum of all squares, an upper bound.
    """
    products = (model.layout.across(residual) if model.between else residual) * residual
    total = [products[model.layout.rows(i)].sum() for i in range(model.base.n)]
    return np.asarray(np.maximum(np.array(total), 0.0))


def repeat_rms(model: Calibrated, residual: Sequence[Array]) -> tuple[Array, Array]:
    """RMS of what repeats (n,) [N m] and how certain that is; NaN without passes.

    certain (n,): sum of products of whitened passes, in deviations of what noise would give.
    """
    n = model.base.n
    total, certain, rows = np.zeros(n), np.zeros(n), np.zeros(n)
    for a, b in pairs(model.blocks):
        both = (model.kept[a] & model.kept[b])[:, None]
        good = both & model.blocks[a].moves & model.blocks[b].moves
        rows += good.sum(axis=0)
        total += np.sum(residual[a] * residual[b], axis=0, where=good)
        for i in range(n):
            noise = model.noise.a[i], float(model.noise.scale[i])
            white = [whitening(*noise, good[:, i]) @ residual[k][:, i] for k in (a, b)]
            certain[i] += float(white[0] @ white[1])
    rows[rows == 0] = np.nan
    return np.sqrt(np.maximum(total / rows, 0.0)), certain / np.sqrt(rows)


def axis_rms(blocks: Sequence[Block], values: Sequence[Array]) -> Array:
    """RMS of each axis (n,) over the usable rows in which it moves; NaN of one that never does."""
    judged = np.concatenate([b.judged for b in blocks])
    count = judged.sum(axis=0).astype(float)
    count[count == 0] = np.nan
    squares = np.concatenate(values) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0, where=judged) / count))
