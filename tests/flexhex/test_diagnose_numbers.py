"""Numbers for a person, with as many digits as are known."""

from __future__ import annotations

import math

import pytest

from flexhex.diagnose.numbers import listed, measured, number, percent, settled, side_by_side
from flexhex.diagnosis.result.estimates import Estimate
from tests.flexhex.diagnoses import estimate


@pytest.mark.parametrize(
    ("value", "half", "unit", "text"),
    [
        (0.05, 0.0031, "N m", "0.050 ± 0.003 N m"),
        (0.05, 0.0014, "N m", "0.0500 ± 0.0014 N m"),
        (3.71, 0.1, "kg", "3.71 ± 0.10 kg"),
        (36.2, 12.0, "1/rad", "36 ± 12 1/rad"),
        (0.02, 0.002, "1", "0.020 ± 0.002"),
        (2e-7, 3e-8, "rad", "(2.0 ± 0.3)e-7 rad"),
        (3.7e-5, 3e-6, "rad/N m", "(3.7 ± 0.3)e-5 rad/N m"),
        (-2e-6, 3e-4, "s", "(0 ± 3)e-4 s"),
        (0.5, math.nan, "s", "0.500 s"),
        (3.0, 0.0, "1", "3"),
    ],
)
def test_digits_are_those_of_the_interval(value: float, half: float, unit: str, text: str) -> None:
    assert measured(estimate(value, half, unit)) == text


@pytest.mark.parametrize(
    ("value", "half", "kept"),
    [(-1.015e-16, 0.0016, 0.0), (3.3e-5, 0.0016, 3.3e-5)],
)
def test_value_beside_its_interval_has_no_noise(value: float, half: float, kept: float) -> None:
    assert settled(Estimate(value, (value - half, value + half), "m")) == kept


def test_lopsided_interval_is_given_by_its_ends() -> None:
    value = Estimate(0.05, (0.04, 0.09), "N m")
    assert measured(value) == "0.0500 N m (0.0400 to 0.0900 N m)"


def test_ends_of_a_small_interval_have_one_power_of_ten() -> None:
    value = Estimate(2.27e-6, (0.0, 1.1e-5), "rad")
    assert measured(value) == "0.227e-5 rad (0 to 1.10e-5 rad)"
    # ends that are unlike in size keep their digits
    assert measured(Estimate(2.5e7, (12.5, 1.2e9), "s")) == "0.0250e9 s (12.5 to 1.20e9 s)"
    assert measured(Estimate(2e-8, (0.0, 1.1e-5), "rad")) == "2.00e-8 rad (0 to 1.10e-5 rad)"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.0090, "0.00900"),
        (1234.5, "1234"),
        (math.nan, "–"),
        (3e-9, "3.00e-9"),
        (1.1e-5, "1.10e-5"),
    ],
)
def test_number_has_significant_digits(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "ends", "texts"),
    [
        (0.0030761, (0.00307, 0.003083), ("0.003076", "0.003070 to 0.003083")),
        (1.55e-6, (-1.08e-5, 1.39e-5), ("0.2e-5", "(-1.1 to 1.4)e-5")),
        (95.14, (93.0, 97.5), ("95.1", "93.0 to 97.5")),
        (-1.2e-16, (-2.0, 2.0), ("0.0", "-2.0 to 2.0")),
        (0.5, (-math.inf, math.inf), ("0.5000", "– to –")),
    ],
)
def test_interval_and_estimate_have_the_same_digits(
    value: float, ends: tuple[float, float], texts: tuple[str, str]
) -> None:
    """Two of the width."""
    assert side_by_side(Estimate(value, ends, "m")) == texts


@pytest.mark.parametrize(
    ("share", "text"), [(0.934, "93 %"), (0.998, "99 %"), (0.9996, "100 %"), (math.nan, "–")]
)
def test_hundred_percent_is_said_only_of_all(share: float, text: str) -> None:
    assert percent(share) == text


def test_words_are_listed() -> None:
    assert [listed([]), listed(["a"]), listed(["a", "b"]), listed(["a", "b", "c"], "or")] == [
        "",
        "a",
        "a and b",
        "a, b or c",
    ]
