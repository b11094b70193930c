"""Orders of a wave over the angle that the search begins from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.orders import (
    TRIED,
    Orders,
    promising_orders,
    smoothed,
    stands_out,
    waves,
)
from flexhex.diagnosis.selection.rows import Rows
from flexhex.fmus.filter.equations import hann
from tests.diagnosis.test_selection import RMS, bench_of

STROKE, WINDOW = 10.0, 0.02


def swept(share: float) -> Any:
    """Rows of one axis; this share of them is slow [0.5 rad/s], the others are fast [20 rad/s]."""
    angle = np.linspace(0.0, STROKE, 8000)
    rate = np.where(np.arange(len(angle)) < share * len(angle), 0.5, 20.0)
    model = SimpleNamespace(base=SimpleNamespace(window=WINDOW))
    return SimpleNamespace(model=model, angles=angle[:, None], rates=rate[:, None])


@pytest.mark.parametrize(
    ("share", "shown"),
    [(1.0, True), (0.15, True), (0.02, True), (0.0, False)],
    ids=["slow", "some", "few", "fast"],
)
def test_wave_is_tried_where_slow_rows_show_it(share: float, shown: bool) -> None:
    """At 20 rad/s the window averages 6 of its periods, and nothing but noise is left. What is slow
    on a part of the stroke alone tells orders apart as that part does."""
    rows, order = swept(share), 100.0
    angle, rate = rows.angles[:, 0], rows.rates[:, 0]
    passing = smoothed(order * rate * WINDOW / (2 * np.pi))
    left = passing * np.cos(order * angle) + 0.02 * np.random.default_rng(1).normal(size=len(angle))
    orders = promising_orders(waves(rows, 0), [left], TRIED).orders
    nearest = min(abs(order - 100.0) for order in orders)
    # half the spacing of points, which are four in what the slow part tells apart
    assert (nearest <= np.pi / (STROKE * (share or 1.0)) / 4) == shown


def turns(seed: int) -> np.ndarray:
    """What an inexact friction leaves: bumps of one width and any size where a motion turns, 20
    times on the stroke."""
    rng, angle = np.random.default_rng(seed), swept(1.0).angles[:, 0]
    places, sizes = rng.uniform(0, STROKE, 20), rng.standard_normal(20)
    bumps = sizes * np.exp(-(((angle[:, None] - places) / 0.01) ** 2))
    return np.asarray(bumps.sum(axis=1))


def test_wave_stands_out_of_what_inexact_friction_leaves() -> None:
    """And of noise; not where it is a fiftieth as large."""
    rows = swept(1.0)
    shown, wave = waves(rows, 0), np.cos(100.0 * rows.angles[:, 0])
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(wave))
    for left, clear in (
        (noise + wave, True),
        (turns(1) + wave, True),
        (turns(1) + wave / 50, False),
    ):
        assert stands_out(shown, [left], 100.0) == clear
    # of an order that the rows do not show they say nothing
    assert stands_out(shown, [noise], 1e9)


def test_waves_of_what_inexact_friction_leaves_do_not_stand_out() -> None:
    """The largest of each residual, in an octave of some hundred waves."""
    rows = swept(1.0)
    shown = waves(rows, 0)
    found = []
    for seed in range(20):
        left = turns(seed)
        listed = promising_orders(shown, [left], TRIED)
        orders = np.array(listed.orders)[list(listed.peaks)]
        found += [stands_out(shown, [left], order) for order in orders if order > 100.0]
    assert len(found) > 20
    assert sum(found) <= 0.02 * len(found)


def test_search_accepts_no_wave_that_bumps_make(tmp_path: Path) -> None:
    """Where nobody had to look for one, as a multiple of a known order, it is none of many."""
    rng = np.random.default_rng(5)
    places, sizes = rng.uniform(-1.5, 1.5, 40), 0.1 * RMS * rng.standard_normal(40)
    bench = bench_of(
        tmp_path,
        lambda q, v, a: (sizes * np.exp(-(((q[..., None] - places) / 0.01) ** 2))).sum(-1),
    )
    there = Hypotheses(bench, Rows.of(bench.model))
    effect = there.effect("cogging_harmonic", 0)
    orders = [effect.shapes[k]["order"] for k in effect.first if effect.shapes[k]["order"] > 500]
    assert len(orders) > 5
    assert not any(there.seen.clear(there.moments, effect, order) for order in orders)
    assert there.seen.clear(there.moments, replace(effect, choices=5), orders[0])


def test_share_that_a_window_leaves_is_its_transform() -> None:
    """Against sums over a Hann window."""
    weights = hann(400)
    clock = (np.arange(len(weights)) - (len(weights) - 1) / 2) / len(weights)
    for periods in (0.0, 0.3, 1.0, 1.5, 2.0, 3.4):
        whole = weights @ np.cos(2 * np.pi * periods * clock) / weights.sum()
        assert smoothed(np.array([periods]))[0] == pytest.approx(whole, abs=0.01)


def test_few_places_show_no_wave() -> None:
    rows = swept(1.0)
    rows.angles, rows.rates = rows.angles[::200], rows.rates[::200]
    left = np.cos(3.0 * rows.angles[:, 0])
    assert promising_orders(waves(rows, 0), [left], TRIED) == Orders((), 0, ())


def test_orders_of_which_an_axis_sees_a_part_are_not_sought(tmp_path: Path) -> None:
    """Nor does a search of the best order end there: what is less than a period over the stroke is
    a spring."""
    bench = bench_of(tmp_path, None)
    theta = np.concatenate([block.run.motion.theta for block in bench.model.blocks])
    for name in ("cogging_harmonic", "torque_ripple"):
        (order,) = bench.searched(name, 0)
        assert order.low == pytest.approx(2 * np.pi / np.ptp(theta), rel=0.02)
