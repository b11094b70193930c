"""Columns kept without zeros do as whole matrices do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design, beside_of

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
