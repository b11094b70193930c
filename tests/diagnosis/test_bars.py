"""What errors in the form of accepted effects may have left is no evidence for another effect."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.bars import Bars, beyond_chance
from flexhex.diagnosis.selection.blur import felt
from flexhex.diagnosis.selection.choose import effect_scores
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from tests.diagnosis.test_selection import RMS, Array, bench_of

LEFT = {0: 1000.0, None: 10.0}


def whole(score: Score, left: float) -> float:
    """A hypothesis that may be all of an error on its axis."""
    return left


BARS = Bars(5.0, 3.0, lambda score: felt(score, LEFT, whole))


def score(gain: float, axis: int, spread: tuple[float, ...] = (), size: float = 0.01) -> Score:
    """Of an effect on an axis."""
    hypothesis: Any = SimpleNamespace(id="drag", axis=axis, choices=1)
    return Score(hypothesis, gain / 2, np.zeros(2), size, spread=spread)


@pytest.mark.parametrize(
    ("axis", "gain", "spread", "left"),
    [
        (0, 1.0, (), 1010.0),
        (1, 1.0, (), 10.0),
        (1, 5000.0, (0.4, 0.6), 410.0),
        (1, 200.0, (0.4, 0.6), 90.0),
    ],
    ids=[
        "same axis",
        "another one",
        "another one that base parameters tie to it",
        "another one, where it gains little",
    ],
)
def test_errors_count_where_they_are_felt(
    axis: int, gain: float, spread: tuple[float, ...], left: float
) -> None:
    """And no more of them than it gains there."""
    assert felt(score(gain, axis, spread), LEFT, whole) == pytest.approx(left)


@pytest.mark.parametrize(("doubt", "there"), [(1.0, True), (9.0, True), (11.0, False)])
def test_rows_that_say_the_same_again_count_once(doubt: float, there: bool) -> None:
    bars = Bars(5.0, 3.0)
    assert beyond_chance(replace(score(50.0, 0), doubt=doubt), (), bars, USUAL) == there


def test_doubt_of_an_effect_is_what_it_leaves(tmp_path: Path) -> None:
    """Friction alone leaves noise; beside a torque that no effect has, rows repeat themselves."""

    def friction(q: Array, v: Array, a: Array) -> Array:
        return 0.1 * RMS * np.tanh(v / 0.01)

    def more(q: Array, v: Array, a: Array) -> Array:
        return friction(q, v, a) + 0.1 * RMS * np.sign(np.sin(40 * q)) * np.sin(7 * v)

    doubts = []
    for name, torque in (("plain", friction), ("more", more)):
        (folder := tmp_path / name).mkdir()
        bench = bench_of(folder, torque)
        moments = Moments(Rows.of(bench.model))
        hypotheses = Hypotheses(bench, moments.rows)
        scores = effect_scores(moments, hypotheses, (), USUAL, [0])
        (dry,) = [s for s in scores if s.hypothesis.id == "coulomb_friction"]
        doubts.append(dry.doubt)
    assert doubts[0] < 5
    assert doubts[1] > 20 * doubts[0]


@pytest.mark.parametrize(
    ("gain", "plain", "there"),
    [(50.0, 2000.0, True), (50.0, 500.0, False), (4.0, 2000.0, False), (1100.0, 0.0, True)],
)
def test_gain_beside_errors_and_gain_without_them_are_both_asked(
    gain: float, plain: float, there: bool
) -> None:
    bars = beyond_chance(score(gain, 0), (), BARS, USUAL, lambda _: score(plain, 0))
    assert bars == there


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_friction_that_grows_with_the_rate_is_friction_and_drag(
    share: float, tmp_path: Path
) -> None:
    """Errors of the form of dry friction may go with the rate; so does drag. Little of it looks
    like Stribeck friction at first."""
    dry, wet = 0.1 * RMS, 0.1 * RMS * share

    def torque(q: Array, v: Array, a: Array) -> Array:
        return dry * np.tanh(v / 0.01) + wet * v * np.abs(v)

    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    values = {named.id: named for named in side.named}
    assert set(values) == {"coulomb_friction", "quadratic_drag"}
    assert values["coulomb_friction"].parameters["F_c"].value == pytest.approx(dry, rel=0.05)
