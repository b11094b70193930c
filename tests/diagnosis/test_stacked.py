"""A shape that the runs do not determine is kept and does not take its gain with it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.stacked import deviations_of
from fmus.common.effects import Shape
from tests.diagnosis.rowsets import layout, regression, signals

ROWS = layout()
SHAPE = Shape("w", "rad", 0.1, 10.0, 2.0, (1.0, 2.0))


def spreads(alike: float) -> tuple[float, dict[str, float]]:
    """Deviations of a gain and of its shape, of which a change looks like the gain itself but for
    `alike` (a share of something else)."""
    own, other = signals(ROWS, 2, 11).T
    column, tangent = own[:, None], (own + alike * other)[:, None]
    part: Any = SimpleNamespace(id="a", axis=0, shape={"w": 2.0})
    bench: Any = SimpleNamespace(effects={"a": SimpleNamespace(searched=[SHAPE])})
    deviation, shape = deviations_of(bench, regression(ROWS), [part], column, tangent)
    return float(deviation[0]), shape[0]


def test_shape_that_shows_has_an_interval() -> None:
    gain, shape = spreads(1.0)
    # 2400 rows of unit noise
    assert shape["w"] == pytest.approx(1 / np.sqrt(2400), rel=0.3)
    assert gain == pytest.approx(np.sqrt(2 / 2400), rel=0.3)


def test_shape_that_does_not_show_leaves_the_gain_its_interval() -> None:
    gain, shape = spreads(1e-2)
    assert shape == {}
    assert gain == pytest.approx(1 / np.sqrt(2400), rel=0.3)
