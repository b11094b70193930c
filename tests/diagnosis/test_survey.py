"""A large grid of shapes is looked at where its evidence is."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design, Stacked
from flexhex.diagnosis.selection.evidence import tried
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.survey import first_of, steps_of, surveyed
from tests.diagnosis.test_selection import CLOCK, bench_of

Array = NDArray[np.float64]
GRID = [{"f": float(f), "zeta": float(z)} for f, z in product(range(30), range(3))]


def test_all_shapes_are_beside_those_that_are_looked_at_first() -> None:
    steps, first = steps_of(GRID), first_of(GRID, ("f", "zeta"))
    assert len(first) == 15
    ways = np.abs(np.array(steps)[:, None] - np.array(steps)[list(first)]).max(axis=2)
    assert ways.min(axis=1).max() == 1
    # of values that are no measure of each other all are looked at
    assert {GRID[k]["f"] for k in first_of(GRID, ("zeta",))} == {own["f"] for own in GRID}
    assert first_of(GRID[:30], ("f", "zeta")) == ()


@pytest.mark.parametrize(("frequency", "zeta"), [(1.5, 0.02), (2.0, 0.2)])
def test_a_mode_is_found_in_fewer_shapes(frequency: float, zeta: float, tmp_path: Path) -> None:
    """As surely as among all of them, with damping of the grid's ends as well."""
    w = 2 * np.pi * frequency
    bench = bench_of(tmp_path, lambda theta, rate, acceleration: _swinging(w, zeta, acceleration))
    hypotheses = Hypotheses(bench, Rows.of(bench.model))
    effect = hypotheses.effect("flexible_mode", 0)
    some, whole = surveyed(hypotheses.moments, effect), tried(hypotheses.moments, effect)
    assert np.isfinite(some[None].evidence).sum() < 0.7 * len(effect.shapes)
    for left, fit in whole.items():
        best = int(np.argmax(fit.evidence))
        assert fit.evidence[best] > 10.0
        assert int(np.argmax(some[left].evidence)) == best
        assert some[left].evidence[best] == pytest.approx(fit.evidence[best], rel=1e-6)


def _swinging(w: float, zeta: float, acceleration: Array) -> Array:
    """Torque [N m] of 0.01 kg m2 that lags behind as a mode."""
    step, e, rate, torque = float(CLOCK[1] - CLOCK[0]), 0.0, 0.0, np.zeros(len(CLOCK))
    for k, a in enumerate(acceleration):
        rate += step * (-a - 2 * zeta * w * rate - w**2 * e)
        e += step * rate
        torque[k] = 0.01 * (-(w**2) * e - 2 * zeta * w * rate - a)
    return torque


def test_stacked_columns_are_those_of_the_rows_that_count() -> None:
    rng = np.random.default_rng(0)
    whole = [rng.normal(size=(m, 2, 4)) for m in (7, 5)]
    kept = [rng.random(len(v)) < 0.7 for v in whole]
    stacked = Stacked([Design.of([v[:, i] for i in range(2)]) for v in whole], kept)
    X = np.concatenate([v[good] for v, good in zip(whole, kept, strict=True)])
    q, values, places = rng.normal(size=4), rng.normal(size=(len(X), 3)), np.array([2, 0])
    for i in range(2):
        np.testing.assert_allclose(stacked.times(i, q), X[:, i] @ q)
        np.testing.assert_allclose(stacked.pulled(i, values), X[:, i].T @ values)
        np.testing.assert_allclose(stacked.squares(i), X[:, i].T @ X[:, i])
        np.testing.assert_allclose(stacked.at(i, places), X[:, i][:, places])
        odd = stacked.only(np.array([1, 3])).times(i, q[:2])
        np.testing.assert_allclose(odd, X[:, i][:, [1, 3]] @ q[:2])
