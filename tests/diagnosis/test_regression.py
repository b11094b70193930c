"""Fits between passes, on rows whose truth is known: bias, falls, intervals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binom, f, kstest

from flexhex.diagnosis.regression.regression import Columns, Regression
from tests.diagnosis.rowsets import CLUSTER, alone, design, layout, regression, signals, whole

Array = NDArray[np.float64]


def squares(y: Array, B: Array, prior: Array) -> float:
    """Least penalised sum of squares, by a stacked least-squares problem."""
    rows = np.vstack([B, np.diag(np.sqrt(prior))])
    wanted = np.concatenate([y, np.zeros(len(prior))])
    left = wanted - rows @ np.linalg.lstsq(rows, wanted, rcond=None)[0]
    return float(left @ left)


def noisy_motion(seed: int) -> Regression:
    """Two columns; the motion of each pass, and so its columns, has noise of its own."""
    rows = layout(instants=2000)
    rng = np.random.default_rng([2, seed])
    B = signals(rows, 2, seed)
    seen = B + 0.5 * rng.standard_normal(B.shape)
    y = B @ np.array([2.0, -1.0]) + 0.3 * rng.standard_normal(len(B))
    return Regression(y, design(seen, rows), np.zeros(2), np.ones(2), rows)


def test_products_between_passes_leave_no_bias_of_noisy_columns() -> None:
    result = noisy_motion(1)
    # 8000 rows, noise 0.64 beside columns of one: a deviation of 0.64 / sqrt(4000) = 0.01
    assert result.q == pytest.approx([2.0, -1.0], abs=0.04)
    # within passes a column of variance 1.25 passes on 1 / 1.25 of its gain
    within = replace(result, layout=alone(result.layout))
    assert within.q == pytest.approx([1.6, -0.8], abs=0.04)


def test_gain_of_an_effect_is_as_unbiased_as_the_base() -> None:
    rows = layout(instants=2000)
    rng = np.random.default_rng([2, 3])
    shared = signals(rows, 1, 3)
    seen = shared + 0.5 * rng.standard_normal(shared.shape)
    fitted = regression(rows)
    fitted = replace(fitted, y=fitted.y + 1.5 * shared[:, 0])
    gain = fitted.gain(Columns(0, seen))
    assert gain.beta == pytest.approx([1.5], abs=0.06)
    assert abs(gain.beta[0] - 1.5) < 3 * np.sqrt(gain.covariance[0, 0])
    within = replace(fitted, layout=alone(rows)).gain(Columns(0, seen))
    assert within.beta == pytest.approx([1.2], abs=0.06)


def test_gain_is_as_sure_as_the_values_that_its_column_depends_on() -> None:
    """One deviation of such a value adds to the torque what it changes: as the gain's error."""
    rows = layout(instants=2000)
    column, other = signals(rows, 2, 4).T
    change = 0.3 * column + other
    fitted = regression(rows)
    moved = replace(fitted, y=fitted.y + change)
    columns = Columns(None, column[:, None])
    alone, unsure = fitted.gain(columns), fitted.gain(columns, change[:, None])
    error = moved.gain(columns).beta - alone.beta
    assert unsure.beta == alone.beta
    more = unsure.covariance - alone.covariance
    assert more[0, 0] == pytest.approx(error[0] ** 2, rel=1e-6)
    assert error[0] == pytest.approx(0.3, abs=0.05)


@pytest.mark.parametrize("passes", [2, 3])
@pytest.mark.parametrize("axis", [0, 1, None])
def test_falls_are_those_of_each_candidate_alone(axis: int | None, passes: int) -> None:
    rows = layout(2, passes)
    fitted = regression(rows, nb=4, prior=0.5)
    C = signals(rows, 6, 5)[rows.rows(axis)]
    falls = fitted.falls(axis, C, 2)
    for at in range(3):
        part = Columns(axis, C[:, 2 * at : 2 * at + 2])
        assert falls[at] == pytest.approx(fitted.fall(part)[0], rel=1e-9)


@pytest.mark.parametrize("prior", [0.0, 40.0])
def test_fall_without_repeats_is_that_of_least_squares(prior: float) -> None:
    fitted = regression(alone(layout(2)), nb=4, prior=prior)
    C = np.random.default_rng(6).standard_normal((len(fitted.y) // 2, 2))
    full = np.vstack([np.zeros_like(C), C])
    both = np.hstack([whole(fitted), full])
    before = squares(fitted.y, whole(fitted), fitted.prior)
    after = squares(fitted.y, both, np.append(fitted.prior, [0.0, 0.0]))
    fall, beta = fitted.fall(Columns(1, C))
    # a ridge of 1e-9 keeps absorbed columns from dividing by zero
    assert fall == pytest.approx(before - after, rel=1e-6)
    assert fitted.extended([Columns(1, C)]).q[-2:] == pytest.approx(beta, rel=1e-6)


def test_hair_that_the_base_leaves_of_a_column_gains_nothing() -> None:
    """1e-8 of the square of a column is rounding of its motion, however well it fits."""
    fitted, other = regression(layout()), signals(layout(), 1, 77)
    fitted = replace(fitted, y=fitted.y + 3 * other[:, 0])
    assert fitted.fall(Columns(0, whole(fitted)[:, :1] + 1e-4 * other))[0] < 1.0
    assert fitted.fall(Columns(0, whole(fitted)[:, :1] + 1e-2 * other))[0] > 1e4


def test_columns_that_the_base_has_too_leave_what_it_leaves() -> None:
    """Whoever of both takes it: nothing is explained twice, and nothing by neither."""
    rows = layout(instants=500)
    fitted = regression(rows)
    twice = fitted.times(np.eye(fitted.B.width))[:, :1]
    other = signals(rows, 1, 5)
    for values in (twice, other, np.hstack([twice, other])):
        beta, q = fitted.together(Columns(None, values))
        left = fitted.y - fitted.times(q) - values @ beta
        assert left.std() <= fitted.residual.std() * (1 + 1e-6)
    assert fitted.together(Columns(None, other))[1] == pytest.approx(
        fitted.extended([Columns(None, other)]).q[: fitted.B.width], rel=1e-6
    )


def p_value(fitted: Regression, columns: Columns) -> float:
    """Of all gains being zero, by their covariance: Wald's test, a degree for each cluster."""
    gain = fitted.gain(columns)
    k = len(gain.beta)
    wald = float(gain.beta @ np.linalg.solve(gain.covariance, gain.beta)) / k
    return float(f.sf(wald, k, fitted.clusters - 1 - k))


def p_values(clustered: float, correlated: bool, count: int = 400) -> Array:
    """p of random candidates where nothing is hidden; clustered: size of what a cluster shares."""
    rows, listed = layout(), []
    for seed in range(count):
        rng = np.random.default_rng([11, seed])
        fitted = regression(rows, seed=seed)
        # each pass has noise of its own, but for a cluster of it the same
        group = np.arange(len(rows.axis)) // CLUSTER
        shared = rng.standard_normal(group.max() + 1)[group]
        C = rng.standard_normal((rows.cluster.max() + 1, 2))[rows.cluster]
        if not correlated:
            C = signals(rows, 2, seed + 1000)
        noise = fitted.y + clustered * shared
        listed.append(p_value(replace(fitted, y=noise), Columns(0, C)))
    return np.array(listed)


@pytest.mark.parametrize(("clustered", "correlated"), [(0.0, False), (1.0, True)])
def test_wald_test_is_calibrated_where_nothing_is_hidden(
    clustered: float, correlated: bool
) -> None:
    """Also where errors and columns go together within a cluster; 60 clusters."""
    p = p_values(clustered, correlated)
    # 400 draws: within what chance does to a share in 999 of 1000 cases
    for level in (0.05, 0.2, 0.5):
        low, high = binom.interval(0.999, len(p), level)
        assert low <= (p < level).sum() <= high, level
    assert kstest(p, "uniform").pvalue > 1e-3


def test_wald_test_without_clusters_would_not_be(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check above can fail: rows taken as independent say `certain` far too often."""
    rows = layout()
    single = replace(rows, cluster=np.arange(len(rows.axis)))
    listed = []
    for seed in range(100):
        rng = np.random.default_rng([11, seed])
        fitted = regression(single, seed=seed)
        shared = rng.standard_normal(len(rows.axis) // CLUSTER)[
            np.arange(len(rows.axis)) // CLUSTER
        ]
        C = rng.standard_normal((rows.cluster.max() + 1, 2))[rows.cluster]
        listed.append(p_value(replace(fitted, y=fitted.y + shared), Columns(0, C)))
    assert np.mean(np.array(listed) < 0.05) > 0.2


def test_parameters_without_data_stay_where_they_are() -> None:
    rows = layout()
    B = signals(rows, 2, 1)
    B[:, 1] = 0.0
    fitted = Regression(B[:, 0] * 3.0, design(B, rows), np.zeros(2), np.ones(2), rows)
    assert fitted.q == pytest.approx([3.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_parameters_that_noise_alone_moves_stay_where_they_are(seed: int) -> None:
    """A joint that does not move has columns of noise: products between passes of about nothing,
    by which a free parameter is anything."""
    rows = layout()
    rng = np.random.default_rng([13, seed])
    B = signals(rows, 3, seed)
    B[:, 1] = rng.standard_normal(len(B))
    # two columns that only noise tells apart: their sum is determined, their difference is not
    B[:, 2] = B[:, 0] + 1e-3 * rng.standard_normal(len(B))
    y = B[:, 0] * 3.0 + rng.standard_normal(len(B))
    fitted = Regression(y, design(B, rows), np.zeros(3), np.ones(3), rows)
    q = fitted.q
    # chance, as in 1200 rows of unit noise
    assert abs(q[1]) < 5 / np.sqrt(len(B))
    assert q[0] + q[2] == pytest.approx(3.0, abs=0.15)
    assert abs(q[0] - q[2]) * 1e-3 < 5 / np.sqrt(len(B))
    assert fitted.residual.std() == pytest.approx(1.0, rel=0.05)
    # what repeats is as it was
    clean = Regression(y, design(B[:, :1], rows), np.zeros(1), np.ones(1), rows)
    assert not clean.firm.any()


def test_strain_is_what_tolerances_are_left_by() -> None:
    rows = layout()
    B = signals(rows, 2, 1)
    fitted = Regression(B @ np.array([3.0, 0.0]), design(B, rows), np.ones(2), np.ones(2), rows)
    assert fitted.strain == pytest.approx(9.0, rel=0.01)


def test_drift_is_found_beside_base_columns_with_noise() -> None:
    """A column of its own in every pass; noise in the base model's columns takes nothing of it,
    nor of the base model's parameters, as it would by ordinary least squares (20 %)."""
    rows = layout()
    rng = np.random.default_rng(8)
    exact = regression(rows, nb=1)
    true = float(exact.q[0]) + 2.0
    B = whole(exact)
    noisy = B + 0.5 * rng.standard_normal(B.shape)
    drift = rng.standard_normal((len(exact.y), 1)) + 0.5 * B
    variant = replace(
        exact,
        y=exact.y + 2.0 * B[:, 0] + 0.3 * drift[:, 0],
        B=design(noisy, exact.layout),
    )
    gain = replace(variant, drifting=True).gain(Columns(None, drift))
    spread = float(np.sqrt(gain.covariance[0, 0]))
    assert gain.beta[0] == pytest.approx(0.3, abs=4 * spread)
    both = replace(variant, drifting=True).extended([Columns(None, drift)])
    assert both.q[0] == pytest.approx(true, rel=0.1)
    assert both.q[1] == pytest.approx(0.3, abs=4 * spread)
    # its square is its own, not that between passes
    assert both.gram[0][1, 1] == pytest.approx(float(drift[:, 0] @ drift[:, 0]))
    # between passes such a column does not repeat
    assert replace(variant, drifting=False).falls(None, drift - 0.5 * B, 1)[0] == 0.0
