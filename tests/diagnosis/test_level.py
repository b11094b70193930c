"""A file whose values are off by many tolerances, all of them."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis import prepare
from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.regression.layout import Layout
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.regression import Regression
from flexhex.diagnosis.selection.changed import WrongFile
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.hypotheses import Hypotheses

COUNT, SHOWN, HIDDEN = 400, 20, 20
"""Rows; parameters that they show, and some that they do not."""


def regression(off: float, seed: int, doubt: float = 1.0) -> Regression:
    """Parameters that are off by so many tolerances, of which half move no row."""
    rng = np.random.default_rng(seed)
    B = np.hstack([rng.standard_normal((COUNT, SHOWN)), np.zeros((COUNT, HIDDEN))])
    y = B @ (off * rng.standard_normal(SHOWN + HIDDEN)) + rng.standard_normal(COUNT)
    alone = np.arange(COUNT)
    rows = Layout(np.zeros(COUNT, dtype=int), np.zeros(COUNT, dtype=int), alone // 20, alone)
    often = np.full(SHOWN + HIDDEN, doubt)
    return Regression(y, Design.of([B]), often, often, rows)


@pytest.mark.parametrize("off", [1.0, 5.0, 50.0])
@pytest.mark.parametrize("doubt", [1.0, 9.0])
def test_fit_finds_how_far_a_file_is_off(off: float, doubt: float) -> None:
    """Whatever the doubt of its parameters, and however many of them the runs do not show.

    The mean of 20 squares has a deviation of a third.
    """
    squares = [freely(regression(off, seed, doubt), SHOWN + HIDDEN)[1] for seed in range(10)]
    np.testing.assert_allclose(np.mean(squares), off**2, rtol=0.3)


def test_free_fit_follows_the_rows() -> None:
    """Held by tolerances that count a thousand times, parameters that are far off stay behind."""
    held = regression(50.0, 0, doubt=1000.0)
    free, _ = freely(held, SHOWN + HIDDEN)
    assert np.square(free.residual).mean() < 2.0
    assert np.square(held.residual).mean() > 100.0


@pytest.mark.parametrize(("off", "times"), [(1.0, []), (49.0, [7.0])])
def test_wrong_file_is_asked_for_where_a_fit_finds_it_off(off: float, times: list[float]) -> None:
    known = [Known(f"m[{k}]", "kg", 2.0, 0.1, "m") for k in range(3)]
    more = Known("delay", "s", 0.0, 1e-3, "delay")
    hypotheses = Hypotheses.__new__(Hypotheses)
    base = SimpleNamespace(linear=known, payload=())
    model: Any = SimpleNamespace(known=[*known, more], scale=np.full(4, 0.1), base=base, off=off)
    hypotheses.rows = SimpleNamespace(model=model)  # type: ignore[assignment]
    wrong = [c for c in hypotheses.changes if isinstance(c, WrongFile)]
    assert [c.deviation(USUAL) for c in wrong] == times
    assert all(c.places == (0, 1, 2) for c in wrong)


def test_file_that_is_merely_off_is_no_other_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the torque may stay beside the file's values, if it is gone beside freer ones."""
    own = regression(50.0, 0, doubt=1000.0)
    torque = np.sqrt((own.y**2).mean())

    def poor(_: Any, left: Any) -> list[int]:
        return [0] if np.sqrt((left**2).mean()) > 0.5 * torque else []

    monkeypatch.setattr(prepare, "poor_axes", poor)
    monkeypatch.setattr(prepare, "with_friction", lambda there: there)
    monkeypatch.setattr(prepare, "together", lambda _: np.ones(1))
    model: Any = SimpleNamespace(
        base=SimpleNamespace(complete=True, n=1, linear=range(SHOWN + HIDDEN)),
        regression=own,
        residual=lambda q: own.y - own.times(q),
    )
    assert poor(model, model.residual(own.q)) == [0]
    assert prepare.misfit(model) == ""
    model.regression = replace(own, y=np.random.default_rng(1).standard_normal(COUNT) * torque)
    model.residual = lambda q: model.regression.y - model.regression.times(q)
    assert "more than 50%" in prepare.misfit(model)
