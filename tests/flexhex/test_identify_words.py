"""Words of `flexhex identify` that need no runs."""

from __future__ import annotations

import pytest

from flexhex.identify.other import late, short


@pytest.mark.parametrize(("delay", "way"), [(0.004, "lags"), (-0.004, "leads")])
def test_delay_of_the_torques_is_said_in_the_words_of_diagnose(delay: float, way: str) -> None:
    assert late(delay).startswith(f"The torque channel {way} the angles by 4 ms, or ")


def test_sum_of_two_long_names_keeps_the_first() -> None:
    terms = ("robot_link5_of_the_wrist.mc_y", 1.0), ("robot_link6_of_the_wrist.mc_z", -0.107)
    assert short(terms) == "robot_link5_of_the_wrist.mc_y + 1 more"
    assert short((("a.m", 1.0), ("b.m", 1.0))) == "a.m + b.m"
