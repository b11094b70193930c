"""Columns that gain nothing: what hardly repeats between passes, or the base model explains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.regression.gram import inverted, safe_gram
from flexhex.diagnosis.regression.regression import Columns
from tests.diagnosis.rowsets import layout, regression, signals, whole


def test_columns_that_hardly_repeat_fall_by_nothing() -> None:
    """A chance product of two passes, however large, is no fall; one that repeats is."""
    rows = layout(instants=100)
    fitted = regression(rows)
    once = 1e-3 * signals(rows, 1, 5) + np.random.default_rng(6).standard_normal((len(fitted.y), 1))
    fall, beta = fitted.fall(Columns(0, once))
    assert abs(fall) < 1e-6
    assert abs(beta[0]) < 1e-6
    assert fitted.falls(0, np.hstack([once, signals(rows, 1, 5)]), 1)[0] == 0.0
    assert fitted.falls(0, signals(rows, 1, 5), 1)[0] > 0.0


def test_spike_that_two_passes_have_elsewhere_gains_nothing() -> None:
    """As what grows without bound at rest becomes: its product between passes is next to nothing,
    and what divides by that is anything."""
    rows = layout(instants=100)
    fitted, spike = regression(rows), np.zeros((len(regression(rows).y), 1))
    spike[[10, 11]] = [[1e-20], [1e-10]]
    other = rows.across(spike)
    fall, beta = fitted.fall(Columns(None, spike + 1e-12 * other))
    assert abs(fall) < 1e-3
    assert fitted.gain(Columns(None, spike + 1e-12 * other)).lost.all()
    assert np.isfinite(beta).all()


def test_column_of_zeros_leaves_the_inverse_of_others_alone() -> None:
    """A gain that is held at zero: its own inverse was 1e291, and rounding passed on some of it."""
    gram = safe_gram(np.diag([4.0, 0.0]), np.array([4.0, 0.0]), np.array([False, True]))
    inverse = inverted(gram)
    assert np.abs(inverse).max() < 1.0
    assert inverse[0, 0] == pytest.approx(0.25, rel=1e-6)


def test_column_that_the_base_explains_gains_nothing() -> None:
    fitted = regression(layout())
    fitted = replace(fitted, y=fitted.y + 5 * whole(fitted)[:, 0])
    fall, _ = fitted.fall(Columns(0, whole(fitted)[:, :1] - 2 * whole(fitted)[:, 1:2]))
    assert abs(fall) < 1e-3
