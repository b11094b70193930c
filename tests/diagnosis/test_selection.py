"""Selection: the closed form against Gaussian densities of rows; what is named on a single axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.stats import multivariate_normal

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.prepare import Options, fitted, run_set_of
from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.result.verdict import UNCONFIRMED
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.evidence import bounded, evidences, tried
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.hypothesis import (
    EffectHypothesis,
)
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.nameless import nameless, tolerated
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.select import Selection, select
from tests.diagnosis.single import SECONDS, TS, moved, thinned, wanted, write

Array = NDArray[np.float64]
CLOCK = np.arange(round(SECONDS / TS)) * TS
RMS = float(wanted(CLOCK, 1).std())
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
Torque = Callable[[Array, Array, Array], Array]
"""Of angle, rate, acceleration."""


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


def test_no_column_takes_more_than_is_left() -> None:
    """Products between passes may lose their sign beside many terms: then a fall knows no end."""
    rng = np.random.default_rng(6)
    B, C, fold = rng.normal(size=(240, 1)), rng.normal(size=(240, 1)), np.arange(240) // 80
    y = B[:, 0] + 3.0 * C[:, 0] + rng.normal(size=240)
    moments = Moments(rows_of(y, B, np.ones(1), fold))
    left = ((y - B @ moments.fit(None).q) ** 2).sum()
    assert moments.most(None) == pytest.approx(left + len(y), rel=1e-6)
    effect = effect_of(C)
    assert tried(moments, effect)[None].evidence[0] > 100
    # a curvature of next to nothing, as rounding leaves it
    products = effect.beside(moments)
    tiny = replace(products, own=1e-9 * products.own, cross=1e-9 * products.cross)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(EffectHypothesis, "beside", lambda *_: tiny)
        assert tried(moments, effect)[None].evidence[0] == -np.inf


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


def bench_of(
    folder: Path,
    torque: Torque | None,
    runs: Sequence[tuple[int, int]] = RUNS,
    step: int = 1,
) -> Bench:
    """Runs (motion, pass) of an axis that feels a further torque [N m]; every so many samples of
    them."""
    paths = []
    for k, (motion, number) in enumerate(runs):
        extra = 0.0 if torque is None else torque(*moved(CLOCK, motion))
        path = write(folder / f"{k}.csv", motion, number, 0.0, extra=extra)
        paths.append(thinned(path, step))
    base, run_set, trouble = run_set_of(paths, [], None, Options(base="axis"))
    assert not trouble
    model, _, _ = fitted(base, run_set.runs)
    return Bench(model, compiled(1, None, model.base.holds))


def chosen(folder: Path, torque: Torque | None) -> Selection:
    """What is chosen there."""
    return select(bench_of(folder, torque))


def names(selection: Selection) -> list[str]:
    return [accepted.score.hypothesis.id for accepted in selection.accepted]


def test_nothing_is_chosen_where_nothing_is_hidden(tmp_path: Path) -> None:
    selection = chosen(tmp_path, None)
    assert not names(selection)
    assert not nameless(selection, USUAL)


@pytest.mark.sample(1)
@pytest.mark.parametrize("order", [18.0, 53.0, 211.0])
def test_cogging_is_named_with_its_order_and_nothing_else(order: float, tmp_path: Path) -> None:
    selection = chosen(tmp_path, lambda q, v, a: 0.01 * RMS * np.sin(order * q + 0.4))
    (accepted,) = selection.accepted
    assert accepted.score.hypothesis.id == "cogging_harmonic"
    assert not accepted.rivals
    shape = accepted.score.hypothesis.shapes[accepted.score.shape]  # type: ignore[union-attr]
    assert shape["order"] == pytest.approx(order, abs=0.3)
    # the smoothing window takes more of a higher order
    assert 0.8 < accepted.score.size / (0.01 / np.sqrt(2)) < 1.05
    assert not nameless(selection, USUAL)


def test_two_effects_on_one_axis_are_both_named(tmp_path: Path) -> None:
    def both(q: Array, v: Array, a: Array) -> Array:
        return 0.02 * RMS * np.tanh(v / 0.01) + 0.01 * RMS * np.sin(80.0 * q)

    selection = chosen(tmp_path, both)
    assert sorted(names(selection)) == ["cogging_harmonic", "coulomb_friction"]
    assert not nameless(selection, USUAL)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "strange",
    [
        lambda q, v, a: 0.06 * RMS * np.exp(-(((q - 0.1) / 0.05) ** 2)),
        lambda q, v, a: 0.03 * RMS * np.tanh(v) * np.sin(5.0 * q),
    ],
    ids=["bump", "rate times angle"],
)
def test_what_the_library_has_not_is_left_without_a_name(strange: Torque, tmp_path: Path) -> None:
    """Names that fit a part of it are imitations: a smooth function predicts better than they."""
    selection = chosen(tmp_path, strange)
    functions = nameless(selection, USUAL)[0]
    sizes = tolerated(selection.accepted, selection.explained[0], USUAL)
    assert functions.size > max(sizes, default=0.0)


def test_one_trajectory_names_nothing(tmp_path: Path) -> None:
    """Two passes of it show that something repeats, not what it is."""
    bench = bench_of(tmp_path, lambda q, v, a: 0.02 * RMS * np.sin(53.0 * q), RUNS[:2])
    side = found(bench, (), lambda text: None).side
    assert not side.named
    assert side.remains == (0,)
    (rest,) = side.rests
    assert (rest.fitted, rest.why) == (("cogging_harmonic",), UNCONFIRMED)
