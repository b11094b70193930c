"""What a model lacks makes its rows less sure of its parameters than noise does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.regression.doubt import doubt
from flexhex.diagnosis.regression.regression import Regression
from tests.diagnosis.rowsets import design, layout, regression, repeated

Array = NDArray[np.float64]
ROWS = layout()
PLACE = np.arange(len(ROWS.axis)) % 600
SLOW = np.column_stack([np.sin(PLACE / k + k) for k in (23.0, 29.0, 31.0, 41.0)])
"""Columns (R, 4) that go on for about a cluster, the same in both passes."""


def test_white_noise_raises_no_doubt() -> None:
    of_noise = [doubt(f.B, [f.residual], ROWS.cluster) for f in map(_fitted, range(20))]
    assert np.mean(of_noise) == pytest.approx(1.1, abs=0.1), "1, but for chance, and never less"


def test_doubt_is_the_variance_of_what_the_residual_says_of_a_column() -> None:
    """Errors that go on for a cluster and repeat: estimates vary so much more than rows say."""
    rng, spread, doubts = np.random.default_rng(4), [], []
    for _ in range(300):
        phase = rng.uniform(0, 2 * np.pi, (len(np.unique(ROWS.cluster)), 1))
        lacking = 3.0 * np.cos(2 * np.pi * PLACE / 20 + phase[ROWS.cluster, 0])
        column = np.cos(2 * np.pi * PLACE / 20)[:, None]
        y = lacking + rng.standard_normal(len(PLACE))
        fitted = Regression(y, design(column, ROWS), np.zeros(1), np.ones(1), ROWS)
        spread.append(float(fitted.q[0]) / np.sqrt(fitted.covariance[0, 0]))
        doubts.append(doubt(fitted.B, [fitted.residual], ROWS.cluster)[0])
    assert np.var(spread) > 50
    assert np.mean(doubts) == pytest.approx(np.var(spread), rel=0.3)


def test_what_the_model_lacks_does_not_move_parameters_that_hardly_matter() -> None:
    """The last column is faint: it would be hundreds of tolerances off to imitate a little of it.
    The first one matters, and is found as it is."""
    rng = np.random.default_rng(2)
    B = SLOW * [100.0, 100.0, 100.0, 0.3]
    lacking = 40.0 * repeated(np.repeat(rng.standard_normal((120, 1)), 20, axis=0), ROWS)[:, 0]
    y = B @ [2.0, 0.0, 0.0, 0.0] + lacking + rng.standard_normal(len(B))
    plain = Regression(y, design(B, ROWS), np.ones(4), np.ones(4), ROWS)
    times = doubt(plain.B, [plain.residual], ROWS.cluster)
    careful = replace(plain, prior=plain.prior * times, doubt=times)
    assert abs(plain.q[3]) > 3
    assert abs(careful.q[3]) < 0.5
    assert careful.q[0] == pytest.approx(2.0, abs=0.15)


def test_freed_parameters_keep_their_doubt() -> None:
    fitted = _fitted(0)
    times = np.array([4.0, 9.0, 1.0])
    careful = replace(fitted, prior=times, doubt=times)
    np.testing.assert_allclose(careful.loosened({1: 0.01}).prior, [4.0, 0.09, 1.0])


def _fitted(seed: int) -> Regression:
    return regression(ROWS, seed=seed)
