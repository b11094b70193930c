"""A step of a shape that explains more with a torque of the wrong sign is too long."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.jointfit.steps import stepped
from flexhex.diagnosis.regression.regression import Columns
from flexhex.fmus.common.effects import Shape
from tests.diagnosis.rowsets import layout, regression, signals
from tests.diagnosis.usual import usual

ROWS = layout()
SHAPE = Shape("w", "rad", 0.1, 10.0, 2.0, (1.0, 2.0))
AWAY = 1.3
"""Angle from a column to the torque [rad]: the tangent there leads to one of the other sign."""


@pytest.mark.parametrize(("low", "near"), [(0.0, 1.0), (-np.inf, -0.7)])
def test_step_leaves_a_gain_the_sign_that_it_must_have(low: float, near: float) -> None:
    one, other = signals(ROWS, 2, 11).T

    def columns(name: str, axis: int, shape: dict[str, float]) -> Columns:
        return Columns(0, (np.cos(shape["w"]) * one + np.sin(shape["w"]) * other)[:, None])

    effect = SimpleNamespace(shapes=[SHAPE], fitted=[SimpleNamespace(low=low)], geared=False)
    items = {"a": SimpleNamespace(searched=[SHAPE], effect=effect)}
    bench: Any = SimpleNamespace(effects=items, scales=usual(items), columns=columns)
    start = Part("a", 0, {"w": 2.0}, columns("a", 0, {"w": 2.0}))
    fitted = replace(regression(ROWS), y=columns("a", 0, {"w": 2.0 + AWAY}).values[:, 0])
    (moved,) = stepped(bench, fitted, [start], [(0, "w")])
    _, gain = fitted.fall(moved.columns)
    assert gain[0] == pytest.approx(near, abs=0.2)
