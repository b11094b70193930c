"""Shapes between the points of a grid: uphill from each of its peaks."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.signal import lsim

from flexhex.diagnosis.selection import refine
from flexhex.diagnosis.selection.choose import effect_scores
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.evidence import mean_of, tried
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.refine import peaks
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, moved, wanted, write
from tests.diagnosis.test_selection import RMS, bench_of

GRID = [{"a": float(a), "b": float(b)} for a, b in product(range(4), range(3))]
CORNER, LOSS = 0.5, 0.08
"""[N m], relative loss per N m beyond it."""
T = TS * np.arange(round(SECONDS / TS))


def test_peaks_are_higher_than_their_neighbours() -> None:
    heights = {(0.0, 0.0): 5.0, (1.0, 0.0): 4.0, (3.0, 2.0): 7.0, (2.0, 2.0): 6.0, (0.0, 2.0): 1.0}
    evidence = np.array([heights.get((shape["a"], shape["b"]), 0.0) for shape in GRID])
    listed = [GRID[k] for k in peaks(GRID, evidence)]
    # the one at (0, 2) is too low
    assert listed == [{"a": 3.0, "b": 2.0}, {"a": 0.0, "b": 0.0}]


def test_a_flat_grid_has_one_start() -> None:
    assert peaks(GRID, np.zeros(len(GRID))) == [0]


def test_corner_is_found_though_the_grid_favours_a_gradual_form(tmp_path: Path) -> None:
    """Iron that saturates from some torque on: of the grid, one that gives way gradually from a
    larger torque on fits best. The library's loss goes with the joint's torque, not the reported
    one, so both agree to first order only."""
    paths = []
    for seed, number in product((1, 2, 3), (1, 2)):
        torque = wanted(T, seed)
        reported = torque.copy()
        for _ in range(60):
            lost = LOSS * reported * np.maximum(0.0, np.abs(reported) - CORNER)
            reported = torque + lost
        path = tmp_path / f"{seed}{number}.csv"
        paths.append(write(path, seed, number, 0.0, extra=reported - torque))
    diagnosis = diagnose(paths[:4], paths[4:], options=Options(base="axis"))
    (effect,) = diagnosis.effects
    assert (effect.id, effect.rivals) == ("torque_constant_saturation", ())
    assert effect.parameters["tau_k"].value == pytest.approx(CORNER, rel=0.1)
    assert effect.parameters["s"].value == pytest.approx(LOSS, rel=0.15)


def test_slow_mode_is_found(tmp_path: Path) -> None:
    """A part of the inertia swings at 1.3 Hz, from rest."""
    w, inertia, zeta = 2 * np.pi * 1.3, 0.01, 0.08
    swing = [w**2, 2 * zeta * w, 1.0]
    paths = []
    for seed, number in product((1, 2, 3), (1, 2)):
        acceleration = moved(T, seed)[2]
        # e'' + 2 zeta w e' + w^2 e = -theta'' between the part and the joint
        _, apart, _ = lsim(([-1.0, 0.0, 0.0], swing[::-1]), acceleration, T)
        path = tmp_path / f"{seed}{number}.csv"
        paths.append(write(path, seed, number, 0.0, extra=inertia * apart))
    (effect,) = diagnose(paths[:4], paths[4:], options=Options(base="axis")).effects
    assert effect.id == "flexible_mode"
    assert effect.parameters["f"].value == pytest.approx(1.3, rel=0.02)
    assert effect.parameters["J_2"].value == pytest.approx(inertia, rel=0.1)


def test_price_of_a_shape_is_what_there_are_beside_it(tmp_path: Path) -> None:
    """Evidence over all places at which a cable might tighten, beside that of the best one, by
    adding up both on a fine grid."""
    bench = bench_of(tmp_path, lambda q, v, a: 0.5 * RMS * np.maximum(q - 0.17, 0.0))
    moments = Moments(Rows.of(bench.model))
    hypotheses = Hypotheses(bench, moments.rows)
    cable = hypotheses.effect("cable_force", 0)
    (score,) = [
        s
        for s in effect_scores(moments, hypotheses, (), USUAL, [0])
        if s.hypothesis.id == "cable_force"
    ]
    places = {shape["theta_0"] for shape in cable.shapes}
    fine = [
        {"theta_0": float(at), "side": side}
        for at in np.linspace(min(places), max(places), 401)
        for side in (-1.0, 1.0)
    ]
    evidence = tried(moments, hypotheses.shaped(cable, *fine), [None])[None].evidence
    assert score.price == pytest.approx(evidence.max() - mean_of(evidence), abs=0.7)


@pytest.mark.parametrize("tied", [0.0, 0.8])
def test_shapes_that_make_up_for_each_other_are_more_alike(
    tied: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a grid 5 by 3 standard deviations apart, each with the other held; what no machine has
    says nothing."""

    def evidence(_: object, shapes: list[dict[str, float]], __: object) -> dict[None, Any]:
        listed = [-(s["a"] ** 2 + s["b"] ** 2 + 2 * tied * s["a"] * s["b"]) / 2 for s in shapes]
        return {None: SimpleNamespace(evidence=np.array(listed))}

    def many() -> float:
        effect = cast(Any, SimpleNamespace(shapes=[{"a": 0.0, "b": 0.0}]))
        free = [SimpleNamespace(name=name, low=-9.0, high=9.0) for name in "ab"]
        of: dict[str, Any] = {"shaped": lambda _, *s: list(s), "searched": lambda _: free}
        shaped = cast(Any, SimpleNamespace(**of))
        found: float = refine._many(cast(Any, None), shaped, effect, {"a": (1, 5), "b": (1, 3)})
        return found

    monkeypatch.setattr(refine, "tried", evidence)
    assert many() == pytest.approx(np.log(15 / (2 * np.pi) * np.sqrt(1 - tied**2)))
    nothing = {None: SimpleNamespace(evidence=np.array([-np.inf, -1.0]))}
    monkeypatch.setattr(refine, "tried", lambda *_: nothing)
    assert many() == pytest.approx(np.log(15 / (2 * np.pi)))


def uphill(tied: float, monkeypatch: pytest.MonkeyPatch, **top: float) -> tuple[Any, float]:
    """Where two shapes end, from the middle of a grid, and the evidence there."""

    def evidence(_: object, shapes: list[dict[str, float]], __: object) -> dict[None, Any]:
        a, b = (np.array([s[name] - top[name] for s in shapes]) for name in "ab")
        return {None: SimpleNamespace(evidence=-500 * (a**2 + b**2 + 2 * tied * a * b))}

    grid = [{"a": float(a), "b": float(b)} for a, b in product((-2, 0, 2), repeat=2)]
    free = [SimpleNamespace(name=name, low=-9.0, high=9.0) for name in "ab"]
    of: dict[str, Any] = {"shaped": lambda _, *s: list(s), "searched": lambda _: free}
    monkeypatch.setattr(refine, "tried", evidence)
    start = {"a": 0.0, "b": 0.0}
    far = float(evidence(None, [start], None)[None].evidence[0])
    effect, shaped = cast(Any, SimpleNamespace(shapes=grid)), cast(Any, SimpleNamespace(**of))
    shape, best, _ = refine._uphill(cast(Any, None), shaped, effect, (start, far), 0.0)
    (where,) = cast(Any, shape)
    return where, best


@pytest.mark.parametrize("tied", [0.0, -0.9])
def test_shapes_that_make_up_for_each_other_are_followed_to_the_top(
    tied: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a mode, frequency and damping: uphill in one of them leads along a ridge in both."""
    where, best = uphill(tied, monkeypatch, a=1.7, b=1.2)
    assert best > -1.5
    assert where == pytest.approx({"a": 1.7, "b": 1.2}, abs=0.15)


@pytest.mark.parametrize("top", [0.05, 0.3, 0.9])
def test_narrow_top_between_flat_neighbours_is_found(
    top: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wave's evidence is a bell much narrower than a coarse grid, whose three values lie on a
    parabola with its top next to the middle one."""

    def evidence(_: object, shapes: list[dict[str, float]], __: object) -> dict[None, Any]:
        away = np.array([s["a"] - top for s in shapes])
        return {None: SimpleNamespace(evidence=200 * np.exp(-((away / 0.5) ** 2) / 2))}

    effect = cast(Any, SimpleNamespace(shapes=[{"a": float(a)} for a in (-5, 0, 5)]))
    free = [SimpleNamespace(name="a", low=-9.0, high=9.0)]
    of: dict[str, Any] = {"shaped": lambda _, *s: list(s), "searched": lambda _: free}
    monkeypatch.setattr(refine, "tried", evidence)
    start = {"a": 0.0}, float(evidence(None, [{"a": 0.0}], None)[None].evidence[0])
    shaped = cast(Any, SimpleNamespace(**of))
    found, best, widths = refine._uphill(cast(Any, None), shaped, effect, start, 0.0)
    assert best > 200 - 0.2
    assert widths["a"][0] == pytest.approx(0.5 / 200**0.5, rel=0.25)
    assert cast(Any, found)[0]["a"] == pytest.approx(top, abs=0.02)


def test_shape_ends_no_farther_than_the_next_of_the_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would be best far beyond all of the grid is another effect."""
    where, _ = uphill(0.0, monkeypatch, a=5.0, b=0.5)
    assert where == pytest.approx({"a": 2.0, "b": 0.5}, abs=0.05)
