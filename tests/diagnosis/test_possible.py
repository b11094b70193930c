"""Parameters that left their tolerances for values that no machine has."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.result.changed import changed_of, impossible
from tests.diagnosis.test_changed import fit_of


@pytest.mark.parametrize(
    ("unit", "off", "odd"),
    [("kg", -25.0, ["m[1]"]), ("kg", -10.0, []), ("kg m", -25.0, [])],
    ids=["below zero", "above", "first moment"],
)
def test_mass_below_zero_is_impossible(unit: str, off: float, odd: list[str]) -> None:
    """Two kilograms, known to 0.1; a first moment may have any sign."""
    fit = fit_of(np.array([off, 0.0, 0.0]), 3)
    model: Any = fit.bench.model
    model.known[:] = [replace(known, unit=unit) for known in model.known]
    assert impossible(fit, [(0,)]) == odd


@pytest.mark.parametrize(("below", "odd"), [(0.5, []), (5.0, ["link.J_xx"])])
def test_moment_that_may_be_above_zero_is_neither_odd_nor_given(
    below: float, odd: list[str]
) -> None:
    """Of a body with another mass: its value is so many deviations below zero."""
    fit = fit_of(np.array([30.0, -10.0, 0.0]), 3)
    model: Any = fit.bench.model
    value, deviation = 0.1 * fit.q[1], 0.1 * float(np.sqrt(fit.covariance[1, 1]))
    nominal = -value - below * deviation
    moment = Known("link.J_xx", "kg m2", nominal, 0.1, "link", file=2 * nominal)
    model.known = [replace(model.known[0], name="link.m", file=2.5), moment, model.known[2]]
    assert moment.positive
    assert impossible(fit, []) == odd
    assert [change.parameter for change in changed_of(fit, [])] == ["link.m"]
