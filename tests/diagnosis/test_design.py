"""Columns kept without zeros do as whole matrices do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.regression.design import Design, beside_of
from flexhex.diagnosis.runs.linear import Linear

Array = NDArray[np.float64]
RNG = np.random.default_rng(4)
ROWS, WIDTH, AXES = 30, 5, 2


def sparse() -> list[Array]:
    """Columns of two axes; each lacks some."""
    whole = RNG.standard_normal((AXES, ROWS, WIDTH))
    whole[0][:, [1, 4]] = 0.0
    whole[1][:, [0]] = 0.0
    return list(whole)


@pytest.mark.parametrize("axis", range(AXES))
def test_products_are_those_of_whole_columns(axis: int) -> None:
    columns = sparse()
    more = np.zeros((ROWS, AXES, 2))
    more[:, 1] = RNG.standard_normal((ROWS, 2))
    design = beside_of(Design.of(columns), more)
    X = np.hstack([columns[axis], more[:, axis]])
    q, v, part = RNG.standard_normal((WIDTH + 2, 3)), RNG.standard_normal((ROWS, 2)), slice(3, 17)
    assert design.whole(axis) == pytest.approx(X)
    assert design.times(axis, q) == pytest.approx(X @ q)
    assert design.pulled(axis, v) == pytest.approx(X.T @ v)
    assert design.pulled(axis, v[part], part) == pytest.approx(X[part].T @ v[part])
    assert design.squares(axis) == pytest.approx(X.T @ X)
    kept = np.array([1, 2, 6])
    assert design.only(kept).whole(axis) == pytest.approx(X[:, kept])
    turned = np.array([6, 0])
    assert design.at(axis, turned) == pytest.approx(X[:, turned])
    assert design.width == WIDTH + 2


@pytest.mark.parametrize("part", [slice(None), slice(None, None, 4)])
def test_columns_of_a_base_model_are_those_that_it_made(part: slice) -> None:
    """Parameters with a tolerance, free ones, and one that is fixed."""
    rows = np.stack(sparse(), axis=1)
    tolerances = (0.1, np.inf, 0.0, 3.0, 0.2)
    linear = Linear.of(rows, [Known(f"p{k}", "", 1.0, t, "") for k, t in enumerate(tolerances)])
    p, places = RNG.standard_normal(WIDTH), [4, 2, 0]
    assert linear.times(p, part) == pytest.approx(rows[part] @ p)
    assert linear.at(places, part) == pytest.approx(rows[part][:, :, places])
    scale = np.array([0.1, 1.0, 0.0, 3.0, 0.2])
    for unit, shared in ((scale, True), (2 * scale, False)):
        design = Design(WIDTH, linear.scaled(unit))
        for axis in range(AXES):
            assert design.whole(axis) == pytest.approx(rows[:, axis] * unit)
            assert 2 not in design.places(axis)
            assert (design.pieces[axis][0][1] is linear.pieces[axis][0][1]) == shared
