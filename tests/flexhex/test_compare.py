"""Comparing two results: figures known beforehand, tolerances from both sides, nothing merged."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest

from flexhex.compare.results import (
    EQUAL,
    ONLY_FIRST,
    ONLY_SECOND,
    OUT,
    UNLIKE,
    Array,
    Comparison,
    Difference,
    Tolerance,
    compare,
    tolerances,
)
from flexhex.fmus.common.errors import UsageError
from flexhex.ssp.results import Group, Result, rate_name

BASE = 0.25e-3
N = 400


def result(
    signals: Mapping[str, Array],
    period: int = 1,
    unit: str = "rad",
    base: float = BASE,
    meta: Mapping[str, str] | None = None,
) -> Result:
    """A result of one rate."""
    group = Group(period, base, signals, dict.fromkeys(signals, unit))
    n = len(next(iter(signals.values())))
    return Result({rate_name(period, base): group}, duration=n * period * base, meta=meta or {})


def wave() -> Array:
    """Three columns whose largest values are 1, 10 and 100."""
    t = np.arange(N) / 40
    return np.cos(t)[:, None] * [1.0, 10.0, 100.0]


def only(comparison: Comparison) -> Difference:
    """The one signal that was compared."""
    (difference,) = comparison.differences
    return difference


def test_the_same_samples_are_equal_without_tolerance() -> None:
    a, b = result({"plant.theta": wave()}), result({"plant.theta": wave()})
    comparison = compare(a, b, Tolerance(rtol=0))
    assert comparison.equal
    assert (only(comparison).worst, only(comparison).state) == (0, EQUAL)
    assert math.isnan(only(comparison).first)


def test_one_bit_is_seen_without_tolerance() -> None:
    changed = wave()
    changed[7, 1] = np.nextafter(changed[7, 1], np.inf)
    comparison = compare(result({"x": wave()}), result({"x": changed}), Tolerance(rtol=0))
    assert not comparison.equal
    assert (only(comparison).element, only(comparison).at) == (2, 7 * BASE)


def test_figures_are_those_of_a_known_difference() -> None:
    """A difference of 0.3 at sample 100 and -0.4 at 300 in column 2 of 3."""
    changed = wave()
    changed[100, 1] += 0.3
    changed[300, 1] -= 0.4
    d = only(compare(result({"x": wave()}), result({"x": changed})))
    assert (d.state, d.element, d.unit, d.rate) == (OUT, 2, "rad", "0.25ms")
    assert d.worst == pytest.approx(0.4, rel=1e-12)
    assert d.rms == pytest.approx(0.5 / math.sqrt(N), rel=1e-12)
    assert d.at == pytest.approx(300 * BASE)
    assert d.first == pytest.approx(100 * BASE)


@pytest.mark.parametrize(
    ("tolerance", "column", "allowed"),
    [
        (Tolerance(atol=1e-3, rtol=0), 0, 1e-3),
        (Tolerance(atol=0, rtol=1e-3), 1, 1e-2),
        (Tolerance(atol=1e-3, rtol=1e-3), 2, 0.101),
        (Tolerance(atol=9, rtol=9, signals={"x": 1e-5}), 2, 1e-5),
    ],
)
def test_tolerance_holds_from_both_sides(tolerance: Tolerance, column: int, allowed: float) -> None:
    for factor, equal in ((0.99, True), (1.01, False)):
        changed = wave()
        changed[200, column] += factor * allowed
        for pair in ((wave(), changed), (changed, wave())):
            comparison = compare(result({"x": pair[0]}), result({"x": pair[1]}), tolerance)
            assert comparison.equal is equal


def test_rates_are_never_merged() -> None:
    """Every second sample is the very same: still not compared, and not equal."""
    a, b = result({"x": wave()}), result({"x": wave()[::2]}, period=2)
    comparison = compare(a, b)
    assert (only(comparison).state, only(comparison).note) == (UNLIKE, "rate 0.25ms and 0.5ms")
    assert not comparison.equal
    assert not compare(a, b, common=True).equal


def test_equal_rates_by_other_base_steps_are_compared() -> None:
    a, b = result({"x": wave()}, period=2), result({"x": wave()}, base=2 * BASE)
    assert compare(a, b).equal


def test_other_unit_and_size_are_not_compared() -> None:
    a = result({"x": wave()})
    assert only(compare(a, result({"x": wave()}, unit="deg"))).note == "unit rad and deg"
    assert only(compare(a, result({"x": wave()[:, :2]}))).note == "size 3 and 2"


def test_missing_signal_is_said_and_counts_unless_only_common_ones_do() -> None:
    a, b = result({"x": wave(), "y": wave()}), result({"x": wave(), "z": wave()})
    comparison = compare(a, b)
    states = {d.signal: d.state for d in comparison.differences}
    assert states == {"x": EQUAL, "y": ONLY_FIRST, "z": ONLY_SECOND}
    assert not comparison.equal
    assert compare(a, b, common=True).equal
    nothing = compare(result({"x": wave()}), result({"z": wave()}), common=True)
    assert not nothing.equal, "nothing in common is not equal"


def test_longer_run_is_not_equal_but_its_common_time_is() -> None:
    a, b = result({"x": wave()}), result({"x": wave()[:300]})
    comparison = compare(a, b)
    assert (only(comparison).state, comparison.equal) == (EQUAL, False)
    assert compare(a, b, common=True).equal
    assert comparison.provenance == {"duration": ("0.1", "0.075")}


def test_nan_equals_nan_and_nothing_else() -> None:
    holed = wave()
    holed[50, 0] = np.nan
    assert compare(result({"x": holed}), result({"x": holed.copy()})).equal
    comparison = compare(result({"x": wave()}), result({"x": holed}), Tolerance(atol=1e9))
    assert not comparison.equal
    assert (only(comparison).worst, only(comparison).at) == (math.inf, 50 * BASE)


def test_worst_relative_to_its_size_comes_first() -> None:
    """A millionth of 100 is larger than a tenth of 1e-6, but matters less."""
    small, large = np.full(N, 1e-6), np.full(N, 100.0)
    a = result({"large": large, "small": small, "same": large})
    b = result({"large": large + 1e-4, "small": small + 1e-7, "same": large})
    assert [d.signal for d in compare(a, b).differences] == ["small", "large", "same"]


def test_worst_in_its_tolerance_comes_first() -> None:
    """A tolerance of its own makes the smaller difference the one that matters."""
    a = result({"coarse": np.ones(N), "fine": np.ones(N)})
    b = result({"coarse": np.full(N, 1.01), "fine": np.full(N, 1.001)})
    limits = Tolerance(signals={"coarse": 1e-2, "fine": 1e-4})
    comparison = compare(a, b, limits).differences
    assert [(d.signal, round(d.over, 6)) for d in comparison] == [("fine", 10), ("coarse", 1)]


def test_states_of_estimator_and_solvers_come_after_motion_and_torque() -> None:
    signals = {"K.p_std": np.ones((N, 2)), "K.p_std[2]": np.ones(N), "N_E.residual": np.ones(N)}
    a = result({"plant.theta": np.ones(N), "plant.fault": np.ones(N), **signals})
    b = result({name: 2 * v for name, v in signals.items()} | {"plant.theta": np.full(N, 1.1)})
    comparison = compare(a, b).differences
    order = ["plant.theta", "K.p_std", "K.p_std[2]", "N_E.residual", "plant.fault"]
    assert [d.signal for d in comparison] == order


def test_what_made_the_runs_different_is_found() -> None:
    same = {"python": "3.11.7", "sha256 plant.fmu": "aa"}
    a = result({"x": wave()}, meta={**same, "casadi": "3.7"})
    b = result({"x": wave()}, meta={**same, "casadi": "3.8", "command": "flexhex run"})
    assert compare(a, b).provenance == {"casadi": ("3.7", "3.8"), "command": ("-", "flexhex run")}


@pytest.mark.parametrize("text", ["x", "x=", "=1", "x=small", ""])
def test_tolerance_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="write SIGNAL=NUMBER"):
        tolerances([text])


def test_tolerance_of_no_signal_or_below_zero_is_refused() -> None:
    a = result({"plant.theta": wave()})
    with pytest.raises(UsageError, match=r"did you mean 'plant\.theta'"):
        compare(a, a, Tolerance(signals={"plant.teta": 1.0}))
    for wrong in (-1.0, math.nan):
        with pytest.raises(UsageError, match="must be a number of at least 0"):
            compare(a, a, Tolerance(atol=wrong))
        with pytest.raises(UsageError, match="must be a number of at least 0"):
            compare(a, a, Tolerance(signals={"plant.theta": wrong}))
