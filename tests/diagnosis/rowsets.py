"""Rows made up for the tests of the regression: two passes of two trajectories, any columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.regression.layout import Layout
from flexhex.diagnosis.regression.regression import Regression

Array = NDArray[np.float64]
INSTANTS, CLUSTER, TRAJECTORIES = 600, 20, 2
"""Instants of a pass, how many of them make a cluster, trajectories."""


def layout(n: int = 1, passes: int = 2, instants: int = INSTANTS) -> Layout:
    """Rows axis by axis, trajectory by trajectory, pass by pass, instant by instant."""
    shape = n, TRAJECTORIES, passes, instants
    axis, fold, number, at = (v.reshape(-1) for v in np.indices(shape))
    cluster = fold * (instants // CLUSTER) + at // CLUSTER
    other = (number + 1) % passes
    partner = np.ravel_multi_index((axis, fold, other, at), shape)
    return Layout(axis, fold, cluster, partner)


def alone(rows: Layout) -> Layout:
    """The same rows, each its own partner: nothing was run twice."""
    return replace(rows, partner=np.arange(len(rows.axis)))


def repeated(values: Array, rows: Layout) -> Array:
    """Values (R, ...) of which every pass shows what the first one does."""
    return np.where(
        (rows.partner < np.arange(len(rows.axis)))[:, None], rows_twin(values, rows), values
    )


def rows_twin(values: Array, rows: Layout) -> Array:
    """What the partner shows."""
    return values[rows.partner]


def signals(rows: Layout, k: int, seed: int) -> Array:
    """k random columns (R, k) that both passes share."""
    return repeated(np.random.default_rng(seed).standard_normal((len(rows.axis), k)), rows)


def regression(rows: Layout, nb: int = 3, seed: int = 0, prior: float = 0.0) -> Regression:
    """Unit noise about a base model of nb shared columns."""
    rng = np.random.default_rng([7, seed])
    B = signals(rows, nb, seed)
    y = B @ rng.standard_normal(nb) + rng.standard_normal(len(B))
    return Regression(y, design(B, rows), np.full(nb, prior), np.ones(nb), rows)


def design(B: Array, rows: Layout) -> Design:
    """Columns (R, nb) of all rows, axis by axis."""
    return Design.of([B[rows.rows(axis)] for axis in range(rows.n)])


def whole(fitted: Regression) -> Array:
    """The same back (R, nb)."""
    return np.concatenate([fitted.B.whole(axis) for axis in range(fitted.layout.n)])
