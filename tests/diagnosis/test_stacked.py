"""A shape that the runs do not determine is kept; gains are as unsure as they go with it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.jointfit.stacked import deviations_of, stack
from flexhex.diagnosis.regression.regression import Columns
from flexhex.fmus.common.effects import Shape
from tests.diagnosis.rowsets import layout, regression, signals
from tests.diagnosis.usual import usual

ROWS = layout()
SHAPE = Shape("w", "rad", 0.1, 10.0, 2.0, (1.0, 2.0))

EFFECT = SimpleNamespace(shapes=[SHAPE], geared=False)
ITEMS = {"a": SimpleNamespace(searched=[SHAPE], effect=EFFECT)}


def spreads(alike: float, same: float = 1.0) -> tuple[float, dict[str, float]]:
    """Deviations of a gain and of its shape, of which a change looks like the gain itself, so many
    times, but for `alike` (a share of something else)."""
    own, other = signals(ROWS, 2, 11).T
    column, tangent = own[:, None], (same * own + alike * other)[:, None]
    part: Any = SimpleNamespace(id="a", axis=0, shape={"w": 2.0}, columns=Columns(0, column))
    bench: Any = SimpleNamespace(effects=ITEMS, scales=usual(ITEMS))
    deviations = deviations_of(bench, regression(ROWS), [part], column, tangent)
    return float(deviations.gains[0]), deviations.shapes[0]


def test_shape_that_shows_has_an_interval() -> None:
    gain, shape = spreads(1.0)
    # 2400 rows of unit noise
    assert shape["w"] == pytest.approx(1 / np.sqrt(2400), rel=0.3)
    assert gain == pytest.approx(np.sqrt(2 / 2400), rel=0.3)


@pytest.mark.parametrize("alike", [1.0, 0.2])
def test_error_of_the_form_moves_a_shape(alike: float) -> None:
    """An error as large as the effect, all of it along what a change of the shape adds to it."""
    own, other = signals(ROWS, 2, 11).T
    y = 3.0 * own
    error = np.linalg.norm(y) * other / np.linalg.norm(other)
    columns = np.column_stack([own, own + alike * other])
    fits = [replace(regression(ROWS), y=torque) for torque in (y, y + error)]
    (_, right), (_, wrong) = (fit.fall(Columns(None, columns)) for fit in fits)
    part: Any = SimpleNamespace(id="a", axis=0, shape={"w": 2.0}, columns=Columns(0, own[:, None]))
    bench: Any = SimpleNamespace(effects=ITEMS, scales=usual(ITEMS))
    deviations = deviations_of(bench, fits[0], [part], columns[:, :1], columns[:, 1:])
    assert deviations.bent[0]["w"] == pytest.approx(wrong[1] - right[1], rel=0.1)
    # the error is none of the effect's own column, so the gain moves with the shape alone
    assert deviations.turned[0] == pytest.approx(right[0] - wrong[0], rel=0.1)


def test_shape_that_does_not_show_leaves_a_gain_that_does_not_go_with_it_its_interval() -> None:
    gain, shape = spreads(1e-2, 0.0)
    assert shape == {"w": np.inf}
    assert gain == pytest.approx(1 / np.sqrt(2400), rel=0.3)


@pytest.mark.parametrize("same", [0.5, 1.0])
def test_gain_is_as_unsure_as_a_shape_that_does_not_show(same: float) -> None:
    """The inertia of a mode far beyond the motion goes with the square of its frequency. The shape
    may be another by as much as it is, which is 2."""
    gain, shape = spreads(1e-4, same)
    assert shape == {"w": np.inf}
    assert gain == pytest.approx(2.0 * same, rel=0.05)


def test_gain_is_no_less_sure_than_the_shape_that_goes_with_it() -> None:
    """The runs say that this shape is right to 1.1, which is more than half of it, of 2."""
    gain, shape = spreads(1 / np.sqrt(2400) / 1.1)
    assert shape == {"w": np.inf}
    assert gain == pytest.approx(1 / np.hypot(1 / 2.0, 1 / 1.1), rel=0.3)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_shape_in_a_small_unit_leaves_the_gain_its_interval(unit: float) -> None:
    """A width of 10 urad: the change with it is a million times the effect's own column."""
    own, other = signals(ROWS, 2, 11).T
    gain = regression(ROWS).gain(Columns(None, np.column_stack([own, unit * other])))
    spread = np.sqrt(np.diag(gain.covariance)) * [1.0, unit]
    np.testing.assert_allclose(spread, 1 / np.sqrt(2400), rtol=0.3)
    assert not gain.lost.any()


def test_shape_whose_change_does_not_repeat_is_not_determined() -> None:
    """The change of a sharp friction is where the jumps are, which two passes have elsewhere."""
    own, _ = signals(ROWS, 2, 11).T
    chance = np.random.default_rng(12).standard_normal((len(own), 1))
    chance -= ROWS.across(chance)  # what one pass has more, the other has less
    one = Columns(0, own[:, None])
    part: Any = SimpleNamespace(id="a", axis=0, shape={"w": 2.0}, columns=one)
    bench: Any = SimpleNamespace(effects=ITEMS, scales=usual(ITEMS))
    deviations = deviations_of(bench, regression(ROWS), [part], own[:, None], chance)
    assert deviations.shapes[0] == {"w": np.inf}
    assert deviations.gains[0] == pytest.approx(1 / np.sqrt(2400), rel=0.3)


@pytest.mark.parametrize("grid", [SHAPE.grid, ()])
@pytest.mark.parametrize("value", [0.05, 0.1, 2.0, 10.0])
def test_shape_is_never_asked_for_beyond_its_bounds(value: float, grid: tuple[float, ...]) -> None:
    """At a bound the change with a shape is one-sided; beyond it a column may be no number. Bounds
    go with the runs: a shape may lie beyond those of other runs than it was found in, and they may
    hold no place of its grid."""
    shape = replace(SHAPE, grid=grid)
    effect = SimpleNamespace(shapes=[shape], geared=False)
    items = {"a": SimpleNamespace(searched=[shape], effect=effect)}
    (own,) = signals(ROWS, 1, 11).T

    def columns(name: str, axis: int, shape: dict[str, float]) -> Columns:
        assert SHAPE.low <= shape["w"] <= SHAPE.high
        return Columns(0, shape["w"] ** 2 * own[:, None])

    bench: Any = SimpleNamespace(effects=items, scales=usual(items), columns=columns)
    fitted = regression(ROWS)
    part: Any = SimpleNamespace(
        id="a", axis=0, shape={"w": value}, columns=Columns(0, own[:, None])
    )
    _, tangents = stack(bench, fitted, [part])
    _, gain = fitted.fall(Columns(None, own[:, None]))
    slope = 2 * max(value, SHAPE.low) * gain[0]
    np.testing.assert_allclose(tangents[:, 0], slope * own, rtol=2e-3)
