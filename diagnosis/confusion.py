"""Confidence, measured: effects put into the user's own model, motion and noise, and looked for.

Each candidate on the axis in question is injected at the size that was found; which one explains
the result best, and which come near, is counted over draws of the noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.rivals import NEAR
from flexhex.diagnosis.verdict import Named

Array = NDArray[np.float64]
SAID = ("alone", "in a set", "other", "none")
SEED = 4


def confusion(held: Joint, effect: Named, trials: int) -> Named:
    """The effect with its row: what is said when it, or a rival of it, is the truth."""
    bench, regression = held.bench, held.bench.made.regression
    axis = effect.axes[0] - 1 if effect.axes else None
    names = bench.names(axis)
    part = next(p for p in held.parts if p.id == effect.id and (p.axis == axis or axis is None))
    k = held.parts.index(part)
    size = float(np.sqrt(((part.columns.values @ held.beta[k]) ** 2).sum()))
    stacks = {name: _grid(bench, name, axis) for name in names}
    solver = _Solver(regression, stacks)
    rows = {}
    for truth in (effect.id, *effect.rivals):
        if truth not in stacks:
            continue
        columns = part.columns if truth == effect.id else _strongest(stacks[truth])
        rows[truth] = solver.row(truth, columns, size, trials)
    return replace(effect, confusion=rows)


def _grid(bench: object, name: str, axis: int | None) -> tuple[Columns, int]:
    grid = bench.grid(name, axis or 0)  # type: ignore[attr-defined]
    first = grid[0][1]
    return Columns(first.axis, np.hstack([c.values for _, c in grid])), first.values.shape[1]


def _strongest(stack: tuple[Columns, int]) -> Columns:
    """Columns of the middle shape of a grid."""
    columns, k = stack
    middle = columns.values.shape[1] // k // 2
    return Columns(columns.axis, columns.values[:, middle * k : (middle + 1) * k])


class _Solver:
    """Falls of all candidates for many right-hand sides at once."""

    def __init__(self, regression: Regression, stacks: dict[str, tuple[Columns, int]]) -> None:
        self.regression = regression
        self.parts = {}
        for name, (columns, k) in stacks.items():
            C = columns.values
            twin, cross, _ = regression.products(columns.axis, C)
            solved = regression.solve(cross)
            inverses = []
            for at in range(0, C.shape[1], k):
                part = slice(at, at + k)
                own = twin[:, part].T @ C[:, part]
                S = own - cross[:, part].T @ solved[:, part] + 1e-9 * np.diag(np.diag(own))
                inverses.append(np.linalg.pinv((S + S.T) / 2))
            self.parts[name] = (regression.layout.rows(columns.axis), twin, inverses, k)

    def row(self, truth: str, columns: Columns, size: float, trials: int) -> dict[str, float]:
        """Shares of trials by what is said."""
        regression = self.regression
        rng = np.random.default_rng(SEED)
        said = dict.fromkeys(SAID, 0.0)
        gains = rng.standard_normal((columns.values.shape[1], trials))
        torque = columns.values @ gains
        torque *= size / np.maximum(np.sqrt((torque**2).sum(axis=0)), 1e-300)
        y = rng.standard_normal((len(regression.y), trials))
        y[regression.layout.rows(columns.axis)] += torque
        y -= regression.B @ regression.solve(regression.twin.T @ y)
        falls = {name: self._falls(name, y) for name in self.parts}
        for t in range(trials):
            best = max(falls, key=lambda name: falls[name][t])
            near = [n for n in falls if falls[n][t] >= NEAR * falls[best][t]]
            if falls[best][t] < 25.0:
                key = "none"
            elif truth not in near:
                key = "other"
            else:
                key = "alone" if near == [truth] else "in a set"
            said[key] += 1 / trials
        return {key: round(value, 3) for key, value in said.items()}

    def _falls(self, name: str, residual: Array) -> Array:
        rows, twin, inverses, k = self.parts[name]
        c = twin.T @ residual[rows]
        falls = [
            np.einsum("kt,kl,lt->t", c[k * j : k * (j + 1)], inverse, c[k * j : k * (j + 1)])
            for j, inverse in enumerate(inverses)
        ]
        return np.asarray(np.max(falls, axis=0))
