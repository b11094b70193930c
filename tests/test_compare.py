"""The comparison helper fails when it should: too large, too small, NaN, wrong shape."""

from __future__ import annotations

import numpy as np
import pytest

from tests.compare import assert_close


def test_assert_close_accepts_what_is_close() -> None:
    assert_close([1.0, 2.0], [1.0, 2.0 + 1e-10], atol=1e-9)
    assert_close(1e6, 1e6 + 0.5, rtol=1e-6)
    assert_close([0.0, 1e6], [0.5, 1e6], rtol=1e-6)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_assert_close_fails_both_ways(sign: float) -> None:
    """Each side off by more than allowed, in either direction and either place."""
    good = np.array([1.0, 2.0, 3.0])
    bad = good + np.array([0.0, sign * 1.01e-9, 0.0])
    for actual, expected in ((bad, good), (good, bad)):
        with pytest.raises(AssertionError, match=r"torque at \(1,\)"):
            assert_close(actual, expected, atol=1e-9, what="torque")
        with pytest.raises(AssertionError, match="torque"):
            assert_close(actual, expected, rtol=1e-10, what="torque")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_assert_close_refuses_what_is_not_finite(bad: float) -> None:
    """NaN compares false with everything and must not pass for that, not even on both sides."""
    for actual, expected in (([1.0, bad], [1.0, 2.0]), ([1.0, 2.0], [1.0, bad]), ([bad], [bad])):
        with pytest.raises(AssertionError, match="holds"):
            assert_close(actual, expected, atol=1e300, what="torque")


@pytest.mark.parametrize("actual", [1.0, [1.0], [[1.0, 1.0]], [1.0, 1.0, 1.0]])
def test_assert_close_refuses_another_shape(actual: object) -> None:
    """Broadcasting would hide a missing axis or a scalar in place of a vector."""
    with pytest.raises(AssertionError, match="shape"):
        assert_close(actual, [1.0, 1.0], atol=1e300)


def test_assert_close_refuses_nothing() -> None:
    with pytest.raises(AssertionError, match="nothing"):
        assert_close([], [], atol=1.0)
