"""What a fit leaves of runs that it was not made from."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.regression.regression import Columns


@pytest.fixture
def others() -> Elsewhere:
    """Three samples of two axes without torque; an effect's column is its width."""
    elsewhere: Any = object.__new__(Elsewhere)
    elsewhere.there = SimpleNamespace(residual=lambda q: [np.zeros((3, 2))])
    elsewhere._bench = SimpleNamespace(
        thin=lambda id, axis, shape: [np.full((3, 1), shape["w"])],
    )
    elsewhere._thin = {}
    return elsewhere


def test_each_shape_has_columns_of_its_own(others: Elsewhere) -> None:
    """Whatever arrays the parts hold: those of a part that is gone may come again for the next."""
    wide = Part("bump", 1, {"w": 2.0}, Columns(1, np.zeros((4, 1))))
    narrow = replace(wide, shape={"w": 0.5})
    left = [others.residual([part], [np.array([3.0])], np.zeros(0)) for part in (wide, narrow)]
    np.testing.assert_allclose([one[0][0] for one in left], [[0.0, -6.0], [0.0, -1.5]])
