"""The comparison of these tests fails when it should."""

from __future__ import annotations

import numpy as np
import pytest

from tests.importers.loop import Rows, assert_same_bits


def test_comparison_sees_one_bit_a_shifted_row_and_a_missing_signal(expected: Rows) -> None:
    assert_same_bits(dict(expected), expected, "itself")
    name = "plant.theta[3]"
    touched = expected[name].copy()
    touched[7000] = np.nextafter(touched[7000], 1.0)
    with pytest.raises(AssertionError, match=r"plant.theta\[3\] differs from row 7000 on"):
        assert_same_bits({**expected, name: touched}, expected, "one bit")
    with pytest.raises(AssertionError, match="differs"):
        assert_same_bits({**expected, name: np.roll(expected[name], 1)}, expected, "late")
    with pytest.raises(AssertionError):
        assert_same_bits({k: v for k, v in expected.items() if k != name}, expected, "less")


def test_comparison_refuses_a_loop_that_rests(expected: Rows) -> None:
    still = {name: np.zeros_like(values) for name, values in expected.items()}
    with pytest.raises(AssertionError, match="rests"):
        assert_same_bits(still, still, "rest")
