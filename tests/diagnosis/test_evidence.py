"""Evidence: the closed form against Gaussian densities of rows; bounds of gains and of falls."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.stats import multivariate_normal

from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.selection.evidence import bounded, evidences, tried
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]


def rows_of(y: Array, B: Array, prior: Array, fold: NDArray[np.int64]) -> Rows:
    """Rows of one axis with noise of one and a torque of RMS two, no trajectory run twice."""
    model: Any = SimpleNamespace(noise=SimpleNamespace(scale=np.ones(1)), between=True)
    alone, moves, design = csr_array(np.eye(len(y))), (np.ones(len(y), dtype=bool),), Design.of([B])
    firm, torque = np.zeros((len(prior), len(prior))), np.array([2.0])
    return Rows(
        model,
        (y,),
        design,
        (y,),
        design,
        moves,
        fold,
        alone,
        prior,
        np.ones_like(prior),
        firm,
        torque,
    )


def effect_of(columns: Array) -> EffectHypothesis:
    """An effect of one shape with these columns (R, k)."""
    most = np.full(columns.shape[1], np.inf)
    return EffectHypothesis(
        "any", 0, ({},), lambda _: {0: columns}, (0,), -most, most, 1, "", False, 1
    )


def log_density(y: Array, columns: Array, variance: Array) -> float:
    """Of rows whose coefficients have these variances and whose noise has one."""
    covariance = np.eye(len(y)) + (columns * variance) @ columns.T
    return float(multivariate_normal(cov=covariance).logpdf(y))


@pytest.mark.parametrize("size", [1.0, 0.3, 0.0])
def test_gain_is_the_log_density_of_the_left_out_rows(size: float) -> None:
    """log p(y_m | others), by densities of all rows at once; the effect is there or is not."""
    rng = np.random.default_rng(4)
    B, C = rng.normal(size=(240, 3)), rng.normal(size=(240, 2))
    y = B @ [1.0, -0.5, 0.2] + size * C @ [0.3, 0.1] + rng.normal(size=240)
    prior, fold = np.array([0.5, 1.0, 2.0]), np.arange(240) // 80
    fits = tried(Moments(rows_of(y, B, prior, fold)), effect_of(C))
    whole, left_out = evidences(fits, [0, 1, 2])
    free = 4.0 / (C**2).mean(axis=0)

    def densities(rows: NDArray[np.bool_]) -> tuple[float, float]:
        """With the effect as likely as without it, and without it."""
        both = np.hstack([B, C])[rows], np.r_[1 / prior, free]
        there, none = log_density(y[rows], *both), log_density(y[rows], B[rows], 1 / prior)
        return float(np.logaddexp(there, none) - np.log(2.0)), none

    every = densities(np.ones(240, dtype=bool))
    wanted_gain = []
    for m in range(3):
        with_it, without = (a - b for a, b in zip(every, densities(fold != m), strict=True))
        wanted_gain.append(with_it - without)
    np.testing.assert_allclose(whole - left_out, wanted_gain, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(("most", "there"), [(0.2, False), (1.0, True)])
def test_gain_that_no_machine_has_is_no_evidence(most: float, there: bool) -> None:
    """Of all rows it is beyond its bound, or of some rows alone: there it is at its bound."""
    rng = np.random.default_rng(5)
    B, C = rng.normal(size=(240, 1)), rng.normal(size=(240, 1))
    fold = np.arange(240) // 80
    y = B[:, 0] + np.array([0.5, 0.5, 1.9])[fold] * C[:, 0] + rng.normal(size=240)
    effect = replace(effect_of(C), high=np.array([most]))
    fits = tried(Moments(rows_of(y, B, np.ones(1), fold)), effect)
    assert max(fit.gains[0, 0] for fit in fits.values()) == most
    assert bool(np.isfinite(fits[None].evidence[0])) == there
    whole, left_out = evidences(fits, [0, 1, 2])
    assert (float((whole - left_out).sum()) > 0.0) == there


def test_passes_that_move_differently_hardly_make_a_gain_smaller() -> None:
    """A cubic spring beside a linear one that takes up most of it, on two passes each of three
    motions, which differ by a tenth."""
    rng, t = np.random.default_rng(8), np.linspace(0.0, 40.0, 400)
    slow = np.sin(t + rng.uniform(0, 6, (3, 1, 1)))
    q = (slow + 0.1 * np.sin(3 * t + rng.uniform(0, 6, (3, 2, 1)))).ravel()
    y = q + 2.0 * q**3 + 0.1 * rng.normal(size=q.shape)
    other = np.arange(len(q)).reshape(3, 2, 400)[:, ::-1].ravel()
    plain = rows_of(y, q[:, None], np.array([1e-3]), np.arange(3).repeat(800))
    rows = replace(plain, twins=csr_array(np.eye(len(q))[other]))
    fits = tried(Moments(rows), effect_of(q[:, None] ** 3))
    assert fits[None].gains[0, 0] == pytest.approx(2.0, rel=0.1)


def test_no_column_takes_more_than_is_left() -> None:
    """Products between passes may lose their sign beside many terms: then a fall knows no end."""
    rng = np.random.default_rng(6)
    B, C, fold = rng.normal(size=(240, 1)), rng.normal(size=(240, 1)), np.arange(240) // 80
    y = B[:, 0] + 3.0 * C[:, 0] + rng.normal(size=240)
    moments = Moments(rows_of(y, B, np.ones(1), fold))
    q = moments.fit(None).q
    left = ((y - B @ q) ** 2).sum()
    assert moments.most(None) == pytest.approx(left + q @ q, rel=1e-6)
    effect = effect_of(C)
    assert tried(moments, effect)[None].evidence[0] > 100
    # a curvature of next to nothing, as rounding leaves it
    products = effect.beside(moments)
    tiny = replace(products, own=1e-9 * products.own, cross=1e-9 * products.cross)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(EffectHypothesis, "beside", lambda *_: tiny)
        assert tried(moments, effect)[None].evidence[0] == -np.inf


def test_column_that_left_out_rows_alone_show_counts_as_none_without_them() -> None:
    """The other one of the shape still says what it says alone."""
    rng = np.random.default_rng(13)
    B, C, fold = rng.normal(size=(240, 1)), rng.normal(size=(240, 2)), np.arange(240) // 80
    C[fold != 1, 1] = 0.0
    y = B[:, 0] + C @ [2.0, 1.0] + rng.normal(size=240)
    moments = Moments(rows_of(y, B, np.ones(1), fold))
    both, one = (tried(moments, effect_of(columns)) for columns in (C, C[:, :1]))
    assert both[None].evidence[0] > one[None].evidence[0] + 10
    assert both[1].evidence[0] == pytest.approx(one[1].evidence[0], rel=1e-6)
    assert both[1].gains[0].tolist() == [pytest.approx(one[1].gains[0, 0]), 0.0]


def test_fall_beyond_what_a_fold_leaves_counts_as_that_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of all rows it is no evidence at all; without some it would make these seem to say more."""
    rng = np.random.default_rng(14)
    B, C, fold = rng.normal(size=(240, 1)), rng.normal(size=(240, 1)), np.arange(240) // 80
    y = B[:, 0] + 3.0 * C[:, 0] + rng.normal(size=240)
    moments, effect = Moments(rows_of(y, B, np.ones(1), fold)), effect_of(C)
    usual = tried(moments, effect)
    most = {None: moments.most(None), 0: 100.0, 1: moments.most(1), 2: moments.most(2)}
    monkeypatch.setattr(Moments, "most", lambda self, left: most[left])
    fits = tried(moments, effect)
    assert 40.0 < fits[0].evidence[0] < 55.0 < usual[0].evidence[0]
    assert [fits[k].evidence[0] for k in (None, 1, 2)] == [
        usual[k].evidence[0] for k in (None, 1, 2)
    ]


def test_column_takes_the_place_of_a_parameter_that_is_far_off() -> None:
    """It leaves less, and the parameter is where it is known to be."""
    rng = np.random.default_rng(8)
    B, fold = rng.normal(size=(240, 1)), np.arange(240) // 80
    C = B + 0.1 * rng.normal(size=(240, 1))
    y = 30.0 * C[:, 0] + rng.normal(size=240)
    moments = Moments(rows_of(y, B, np.array([1000.0]), fold))
    fits = tried(moments, effect_of(C))
    left = ((y - B @ moments.fit(None).q) ** 2).sum()
    assert 2 * fits[None].evidence[0] > 1.1 * left
    assert fits[None].gains[0, 0] == pytest.approx(30.0, rel=0.02)


@pytest.mark.parametrize(("breakaway", "there"), [(1.5, True), (3.0, False)])
def test_breakaway_torque_without_the_friction_that_it_needs_is_no_evidence(
    breakaway: float, there: bool
) -> None:
    rng = np.random.default_rng(7)
    B, C, fold = rng.normal(size=(240, 1)), rng.normal(size=(240, 2)), np.arange(240) // 80
    y = B[:, 0] + C @ [1.0, breakaway] + 0.1 * rng.normal(size=240)
    effect = replace(effect_of(C), ordered=((1, 0, 2.0),))
    fits = tried(Moments(rows_of(y, B, np.ones(1), fold)), effect)
    assert bool(np.isfinite(fits[None].evidence[0])) == there


def test_gains_lie_within_their_bounds() -> None:
    """By the conditions of a minimum with bounds: no way down that is allowed."""
    rng = np.random.default_rng(3)
    half = rng.normal(size=(40, 3, 5))
    S, c = half @ half.transpose(0, 2, 1), 3.0 * rng.normal(size=(40, 3))
    low, high = np.array([0.0, -np.inf, 0.0]), np.array([np.inf, 0.5, 0.7])
    gains, fall = bounded(S, c, low, high)
    bent = (S @ gains[:, :, None])[:, :, 0]
    slope, least, most = bent - c, gains == low, gains == high
    assert least.any()
    assert most.any()
    assert ((gains >= low) & (gains <= high)).all()
    assert (slope[least] > -1e-9).all()
    assert (slope[most] < 1e-9).all()
    np.testing.assert_allclose(slope[~least & ~most], 0.0, atol=1e-9)
    np.testing.assert_allclose(fall, (gains * (2 * c - bent)).sum(axis=1), rtol=1e-9)
