"""A changed parameter is named with an interval that holds the truth; tolerances are no change."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.base import Known
from flexhex.diagnosis.calibrate import LOOSE
from flexhex.diagnosis.changed import FALL, changes, only_changed
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.verdict import Changed, Estimate
from flexhex.diagnosis.workflow import _possible, _verdict
from tests.diagnosis.rowsets import layout, signals

Array = NDArray[np.float64]
KNOWN = (
    Known("flexure[1].k_u2", "N m/rad", 4.0, 0.2, "flexure.k_u2"),
    Known("flexure[2].k_u2", "N m/rad", 4.0, 0.2, "flexure.k_u2"),
    Known("flexure[3].k_u2", "N m/rad", 4.0, 0.2, "flexure.k_u2"),
    Known("o[1]", "N m", 0.1, 0.05, "o[1]", 0),
    Known("end_effector.m", "kg", 3.0, 0.05, "end_effector.m"),
    Known("end_effector.mc_z", "kg m", 0.6, 0.02, "end_effector.mc_z"),
    Known("delay", "s", 0.0, 1e-4, "delay"),
)
SCALE = np.array([LOOSE * k.tolerance for k in KNOWN])
ROWS = layout()
GAIN = 0.5
"""Effect of one tolerance twice over, relative to the noise of a row: 2400 rows tell it to 0.04."""


def rows(off: dict[str, float], seed: int = 0) -> Regression:
    """Rows of a machine whose parameters differ from KNOWN by `off`, in their units."""
    rng = np.random.default_rng([1, seed])
    B = GAIN * signals(ROWS, len(KNOWN), 100 + seed)
    q = np.array([off.get(k.name, 0.0) for k in KNOWN]) / SCALE
    y = B @ q + rng.standard_normal(len(B))
    return Regression(y, B, np.ones(len(KNOWN)), ROWS)


def held(found: Changed, truth: float) -> bool:
    low, high = found.estimate.ci95
    return low < truth < high


@pytest.mark.parametrize(
    ("name", "off"),
    [("flexure[2].k_u2", 1.2), ("o[1]", -0.4), ("end_effector.mc_z", 0.15)],
)
def test_changed_parameter_alone_is_named(name: str, off: float) -> None:
    (found,) = changes(rows({name: off}), KNOWN, {})
    nominal = next(k.nominal for k in KNOWN if k.name == name)
    assert (found.parameter, found.nominal) == (name, nominal)
    assert held(found, nominal + off), found
    assert not held(found, nominal)


def test_intervals_hold_the_truth_about_as_often_as_they_say() -> None:
    said = [changes(rows({"o[1]": 0.4}, seed), KNOWN, {}) for seed in range(60)]
    found = [one for listed in said for one in listed if one.parameter == "o[1]"]
    assert len(found) == 60
    hits = sum(held(one, 0.5) for one in found)
    # wider than 95 %, for what the noise model does not know: deviations grow by sqrt(3)
    assert hits >= 57
    widths = [one.estimate.ci95[1] - one.estimate.ci95[0] for one in found]
    # 2400 rows, of which 1200 differ: 1.96 x 2 sqrt(3) / (0.5 sqrt(2400)) x 0.1 N m
    assert np.mean(widths) == pytest.approx(0.0277, rel=0.1)


def test_what_is_within_tolerances_is_no_change() -> None:
    """All parameters drawn from their tolerances, forty times."""
    for seed in range(40):
        rng = np.random.default_rng([3, seed])
        off = {k.name: k.tolerance * float(rng.standard_normal()) for k in KNOWN}
        assert changes(rows(off, seed), KNOWN, {}) == [], seed


def test_change_of_three_tolerances_is_none_and_of_six_is_one() -> None:
    # penalised: (3 / LOOSE)^2 x LOOSE^2 = 9 below FALL, 36 above it
    assert 9 < FALL < 36
    assert changes(rows({"o[1]": 3 * 0.05}), KNOWN, {}) == []
    assert [c.parameter for c in changes(rows({"o[1]": 6 * 0.05}), KNOWN, {})] == ["o[1]"]


def test_kind_that_changes_on_all_arms_is_named_as_one() -> None:
    off = {k.name: 1.2 for k in KNOWN if k.group == "flexure.k_u2"}
    (found,) = changes(rows(off), KNOWN, {})
    assert found.parameter == "flexure.k_u2"
    assert held(found, 5.2)


def test_two_changes_are_both_named() -> None:
    found = changes(rows({"o[1]": 0.4, "end_effector.mc_z": 0.2}), KNOWN, {})
    assert {c.parameter for c in found} == {"o[1]", "end_effector.mc_z"}


def test_payload_is_a_mass_and_not_its_moments() -> None:
    """0.5 kg at 0.2 m move m and mc_z together."""
    point = np.array([0, 0, 0, 0, 1.0, 0.2, 0])
    made = rows({"end_effector.m": 0.5, "end_effector.mc_z": 0.1})
    (found,) = changes(made, KNOWN, {"end_effector.m": point})
    assert found.parameter == "end_effector.m"
    assert held(found, 3.5)


def test_delay_of_the_logger_is_no_parameter_of_the_machine() -> None:
    assert changes(rows({"delay": 2e-3}), KNOWN, {}) == []


def test_axes_of_unknown_mass_have_no_change() -> None:
    free = tuple(replace(k, tolerance=np.inf) for k in KNOWN)
    off = {k.name: 1.2 for k in KNOWN if k.group == "flexure.k_u2"}
    assert changes(rows(off), free, {}) == []


@pytest.mark.parametrize(
    ("unit", "nominal", "value", "possible"),
    [
        ("kg", 0.2, 0.3, True),
        ("kg", 0.2, 0.05, False),
        ("kg", 0.2, 0.6, False),
        ("kg", -0.002, 0.004, True),
        ("N m s/rad", 0.2, 1.0, True),
        ("N m s/rad", 0.2, -1.0, False),
    ],
)
def test_change_is_possible_by_its_ratio_unless_about_zero_or_damping(
    unit: str, nominal: float, value: float, possible: bool
) -> None:
    estimate = Estimate(value, (value - 0.0025, value + 0.0025), unit)
    assert _possible(Changed("m", nominal, estimate)) is possible


@pytest.mark.parametrize(
    ("value", "verdict"), [(0.15, "changed"), (0.013, "cannot tell"), (None, "cannot tell")]
)
def test_run_made_once_tells_of_no_impossible_parameter(value: float | None, verdict: str) -> None:
    """Measured: 10 s of the loop through the gateway asked for an eighth of an inertia."""
    changed = []
    if value is not None:
        estimate = Estimate(value, (value - 0.001, value + 0.001), "kg m2")
        changed.append(Changed("end_effector.J_zz", 0.106, estimate))
    made: Any = SimpleNamespace(noise=SimpleNamespace(repeats=False))
    notes: list[str] = []
    assert _verdict(made, [], [], changed, notes, np.zeros(6)) == verdict
    assert any("J_zz" in note for note in notes) is (value == 0.013)


@pytest.mark.parametrize(
    ("off", "size", "change"),
    [(1.2, 0.0, True), (0.0, 1.0, False), (1.2, 1.0, False), (0.0, 0.0, False)],
    ids=["change", "effect", "both", "neither"],
)
def test_effect_that_is_a_changed_parameter_is_told(off: float, size: float, change: bool) -> None:
    """A column that is for the most part like that of a parameter; beside the true change it
    explains nothing, and beside a true effect the parameter leaves what they do not share."""
    made = rows({"flexure[2].k_u2": off})
    own = made.B[:, 1:2] / GAIN
    column = 0.8 * own + 0.6 * signals(ROWS, 1, 500)
    made = replace(made, y=made.y + size * column[:, 0])
    assert only_changed(made, Columns(None, column), KNOWN, {}) is change


def test_parameters_that_nobody_knows_are_no_change() -> None:
    free = tuple(replace(k, tolerance=np.inf) for k in KNOWN[:-1])
    made = rows({"flexure[2].k_u2": 5.0})
    assert not only_changed(made, Columns(None, made.B[:, 1:2]), (*free, KNOWN[-1]), {})
