"""What a search keeps: no more than its own bytes, and nothing twice."""

from __future__ import annotations

import gc
from dataclasses import replace
from pathlib import Path
from typing import Any
from weakref import ReferenceType, ref

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.hypotheses import candidates
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.regression.fitted import FixedEffect
from flexhex.diagnosis.selection import select as module
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.products import ShapeProducts
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.select import select
from flexhex.fmus.common.effects import library
from flexhex.numeric.rows import alike, native
from tests.compare import assert_close
from tests.diagnosis.test_evidence import rows_of
from tests.diagnosis.test_selection import RMS, bench_of

Array = NDArray[np.float64]
SHAPES, ROWS = 40, 200


def test_products_with_terms_are_kept_once() -> None:
    """Of 40 shapes: kept as a view of all shapes each, they would take 40 times as much."""
    rng = np.random.default_rng(5)
    y, B, C = (rng.normal(size=(ROWS, k)) for k in (1, 3, SHAPES))
    fold = np.repeat(np.arange(2), ROWS // 2)
    moments = Moments(rows_of(y[:, 0], B, np.ones(3), fold))
    for _ in range(2):
        own = {0: rng.normal(size=(ROWS, 6))}
        moments = moments.extended(Term(own, own, np.ones(6)))
    shapes = tuple({"s": float(k)} for k in range(SHAPES))
    most, known = np.full(1, np.inf), tuple(ShapeProducts() for _ in shapes)

    def columns(chosen: Any) -> dict[int, Array]:
        return {0: C[:, [int(shape["s"]) for shape in chosen]]}

    effect = EffectHypothesis(
        "any", 0, shapes, columns, (0,), -most, most, 1, "", False, 1, known=known
    )
    effect.beside(moments)
    kept = [products for shape in known for products in shape.terms.values()]
    held = {id(a.base): a.base for a in kept if a.base is not None}
    assert len(kept) == 2 * SHAPES
    assert sum(whole.nbytes for whole in held.values()) == sum(a.nbytes for a in kept)


def test_products_are_those_of_each_shape_alone() -> None:
    """With those that are known already beside them or not."""
    rng = np.random.default_rng(6)
    y, B, C = (rng.normal(size=(ROWS, k)) for k in (1, 3, 4))
    moments = Moments(rows_of(y[:, 0], B, np.ones(3), np.repeat(np.arange(2), ROWS // 2)))
    own = {0: rng.normal(size=(ROWS, 2))}
    moments = moments.extended(Term(own, own, np.ones(2)))
    known, most = [ShapeProducts() for _ in range(2)], np.full(2, np.inf)

    def effect_of(chosen: list[int]) -> EffectHypothesis:
        def columns(shapes: Any) -> dict[int, Array]:
            return {0: np.hstack([C[:, 2 * int(s["s"]) :][:, :2] for s in shapes])}

        shapes, of = tuple({"s": k} for k in chosen), tuple(known[k] for k in chosen)
        bounds = -most, most
        return EffectHypothesis("any", 0, shapes, columns, (0,), *bounds, 1, "", False, 1, known=of)

    effect_of([1]).beside(moments)
    both = effect_of([0, 1]).beside(moments)
    X, first = np.hstack([B, own[0]]), slice(0, ROWS // 2)
    # nothing repeats: one way to take products
    assert len(both.cross) == 1
    assert_close(both.cross[0, 0], X[first].T @ C[first], atol=1e-12)
    assert_close(both.right[0], y[first, 0] @ C[first], atol=1e-12)
    for k in range(2):
        part = C[first, 2 * k : 2 * k + 2]
        assert_close(both.own[0, k], part.T @ part, atol=1e-12)
    rest = both.without(0)[0]
    assert_close(rest[0], X[ROWS // 2 :].T @ C[ROWS // 2 :], atol=1e-12)


def test_products_of_passes_are_between_them_and_within_each() -> None:
    """Of a model that was made longer and shorter again, with each other and with columns."""
    rng = np.random.default_rng(9)
    y, B, C = (rng.normal(size=(ROWS, k)) for k in (1, 3, 2))
    plain = rows_of(y[:, 0], B, np.ones(3), np.zeros(ROWS, dtype=np.int64))
    other = np.roll(np.arange(ROWS), ROWS // 2)
    rows = replace(plain, twins=csr_array(np.eye(ROWS)[other]))
    first, last = ({0: rng.normal(size=(ROWS, 2))} for _ in range(2))
    terms = [Term(own, own, np.ones(2)) for own in (first, last)]
    moments = Moments(rows).extended(terms[0]).extended(terms[1]).without(terms[0])
    X, most = np.hstack([B, last[0]]), np.full(2, np.inf)
    effect = EffectHypothesis("any", 0, ({},), lambda _: {0: C}, (0,), -most, most, 1, "", False, 1)
    products = effect.beside(moments)
    for way, values in enumerate((X[other], X)):
        whole = values.T @ X
        assert_close(moments.grams(0)[0][way], (whole + whole.T) / 2, atol=1e-12)
        assert_close(products.cross[way, 0], values.T @ C, atol=1e-12)
    assert_close(products.own[0, 0], C.T @ C, atol=1e-12)
    assert_close(moments.grams(0)[1], X[other].T @ y[:, 0], atol=1e-12)


def test_columns_of_one_effect_leave_those_of_others_as_they_are(tmp_path: Path) -> None:
    """Beside friction that was found one goes with the torque of the base model, one with all of
    it: at the same samples, of which none are left out here."""
    plain = bench_of(tmp_path, None, step=4)
    assert all(block.every == 1 for block in plain.model.blocks)
    (shape, *_) = plain.shapes("coulomb_friction", 0)
    rubs = FixedEffect(plain.effects["coulomb_friction"], 0, shape, np.array([0.5]))
    model = replace(plain.model, fitted=replace(plain.model.fitted, effects=(rubs,)))
    listed = ["drive_gain", "load_friction", "flexible_mode"]
    effects = compiled(1, {name: library()[name] for name in listed})

    def columns(order: list[str]) -> dict[str, list[Array]]:
        own = Bench(model, effects)
        return {name: own.thin(name, 0, own.shapes(name, 0)[0]) for name in order}

    forth, back = columns(listed), columns(listed[::-1])
    for name in listed:
        for one, other in zip(forth[name], back[name], strict=True):
            assert_close(one, other, rtol=1e-6, what=name)  # some are kept in half the digits


def test_columns_of_the_motion_alone_are_made_once_for_all_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = bench_of(tmp_path, None)
    shape = bench.shapes("coulomb_friction", 0)[0]
    ripple = {"order": 7.0}
    first = bench.thin("coulomb_friction", 0, shape)
    bench.thin("torque_ripple", 0, ripple)
    made, asked = Bench._smoothed, list[str]()

    def counted(own: Bench, item: Any, axis: int, chosen: Any) -> list[Array]:
        asked.append(item.effect.id)
        return made(own, item, axis, chosen)

    monkeypatch.setattr(Bench, "_smoothed", counted)
    again = bench.beside(bench.model)
    for one, other_one in zip(again.thin("coulomb_friction", 0, shape), first, strict=True):
        np.testing.assert_allclose(one, other_one, rtol=1e-6)  # in half the digits
    again.thin("torque_ripple", 0, ripple)
    assert asked == ["torque_ripple"]  # the torque is the fit's
    other = dict(shape) | {name: 2 * value for name, value in shape.items()}
    monkeypatch.setattr(candidates, "KEPT", 0)
    for _ in range(2):
        again.thin("coulomb_friction", 0, other)
    assert asked[1:] == 2 * ["coulomb_friction"]


def test_an_effect_of_the_motion_alone_asks_for_no_torque(tmp_path: Path) -> None:
    """Others do, and then all have the same signals."""
    bench, again = (bench_of(folder, None) for folder in 2 * [tmp_path])
    for own in (bench, again):
        vars(own.model).pop("raw", None)
    (before,) = bench.grid("cubic_stiffness", 0)
    assert "raw" not in vars(bench.model)
    again.thin("torque_ripple", 0, {"order": 7.0})
    assert "raw" in vars(again.model)
    (after,) = again.grid("cubic_stiffness", 0)
    assert_close(before[1].values, after[1].values, 1e-12, what="columns")


def test_scores_of_a_finished_search_hold_no_products(tmp_path: Path) -> None:
    """There are as many of them as of columns."""
    rounds = select(bench_of(tmp_path, lambda q, v, a: 0.02 * RMS * np.sin(20.0 * q))).rounds
    effects = [s.hypothesis for scores in rounds for s in scores]
    held = [e for e in effects if isinstance(e, EffectHypothesis)]
    assert held
    assert not any(e._base or "_with" in vars(e) for e in held)
    assert not any(known.base or known.terms for e in held for known in e.known)


def test_a_search_begins_without_what_the_one_before_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hypotheses and what makes their columns refer to each other: only a collection frees them."""
    kept = list[ReferenceType[Hypotheses]]()

    def made(bench: Bench, rows: Rows) -> Hypotheses:
        assert all(one() is None for one in kept)
        hypotheses = Hypotheses(bench, rows)
        kept.append(ref(hypotheses))
        return hypotheses

    monkeypatch.setattr(module, "Hypotheses", made)
    bench = bench_of(tmp_path, None)
    monkeypatch.setattr(bench, "names", lambda axis: ["coulomb_friction"] if axis == 0 else [])
    gc.disable()
    try:
        for _ in range(2):
            select(bench)
    finally:
        gc.enable()
    assert len(kept) == 2


def test_rows_that_are_alike_are_as_good_as_copies() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    (function,) = native([ca.Function("native_alike", [x, p], [x[0] * p[2] + x[1] - p[0]])])
    rows, same = np.random.default_rng(1).normal(size=(5, 2)), np.array([1.0, 2.0, 3.0])
    (one,), (other,) = function(rows, alike(same, 5)), function(rows, np.tile(same, (5, 1)))
    np.testing.assert_array_equal(one, other)
    with pytest.raises(ValueError, match="input 2"):
        function(rows, alike(same, 4))
