"""Steps of the shapes of all effects together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.jointfit.stacked import stack
from flexhex.diagnosis.regression.regression import Columns, Regression

Array = NDArray[np.float64]
SHARES = (1.0, 0.5, 0.25)
"""Of a step of the shapes that are tried."""


def stepped(
    bench: Bench,
    regression: Regression,
    parts: Sequence[Part],
    shaped: Sequence[tuple[int, str]],
) -> list[Part]:
    """All shapes after one Gauss-Newton step together, or a part of it, that explains more with
    gains that a machine can have if it has them now."""
    columns, tangents = stack(bench, regression, parts)
    before, gains = regression.fall(Columns(None, columns))
    _, step = regression.fall(Columns(None, np.hstack([columns, tangents])))
    low = np.concatenate([_least(bench, part) for part in parts])
    low[gains < low] = -np.inf
    for share in SHARES:
        shapes = [dict(part.shape) for part in parts]
        for (k, name), move in zip(shaped, step[columns.shape[1] :], strict=True):
            shape = bench.scales.ranges(parts[k].id, parts[k].axis or 0)[name]
            there = shapes[k][name] + share * move
            shapes[k][name] = float(np.clip(there, shape.low, shape.high))
        moved = [part.moved(bench, shape) for part, shape in zip(parts, shapes, strict=True)]
        spread = np.hstack([regression.spread(part.columns) for part in moved])
        after, gains = regression.fall(Columns(None, spread))
        if after > before and (gains >= low).all():
            return moved
    return list(parts)


def _least(bench: Bench, part: Part) -> Array:
    """Least gains (k,) of a part: zero where they cannot be negative."""
    known = bench.effects.get(part.id)
    if known is None:
        return np.full(part.columns.values.shape[1], -np.inf)
    return np.array([0.0 if gain.low == 0 else -np.inf for gain in known.effect.fitted])
