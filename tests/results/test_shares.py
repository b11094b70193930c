"""Shares of counted cases."""

from __future__ import annotations

import pytest

from results.shares import share, wilson


def test_wilson_is_the_textbooks() -> None:
    """Newcombe (1998), table I: 81 of 263 and 0 of 20."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(0, 0) == (0.0, 1.0)
    assert share(0, 17) == "0 of 17 (95 % interval 0 to 18 %)"
    assert share(0, 0) == "no case"
