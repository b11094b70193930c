"""Angles in another unit on a machine of which one axis slides: two links on a lift."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.runs.pairing import mispaired
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.init.two_links import GRAVITY, TwoLinks
from tests.diagnosis.two_links import TS, moved, torque

Array = NDArray[np.float64]
CLOCK = np.arange(5000) * TS
MASS = 30.0
"""What the lift carries [kg]."""


class LiftedLinks(TwoLinks):
    """The lift feels nothing of how the links move."""

    axes = ("linear", "rotary", "rotary")  # type: ignore[assignment]
    parameters = (("lift.m", "kg", MASS, 1.5), *TwoLinks.parameters)  # type: ignore[assignment]

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Force and torques (samples, 3) for one of each parameter, (samples, 3, 6)."""
        links = super().columns(theta[:, 1:], thetad[:, 1:], thetadd[:, 1:])
        whole = np.zeros((len(theta), 3, 6))
        whole[:, 0, 0] = thetadd[:, 0] + GRAVITY
        whole[:, 1:, 1:] = links
        return whole


def runs(times: Array, efforts: Array | float = 1.0) -> list[Run]:
    """Two motions as a log would have them whose positions and efforts are so many times too
    large."""
    listed = []
    for seed in (1, 2):
        links, lift = moved(CLOCK, seed), moved(CLOCK, seed + 10)
        q, v, a = (np.column_stack([0.1 * y[:, 0], x]) for x, y in zip(links, lift, strict=True))
        effort = np.column_stack([MASS * (a[:, 0] + GRAVITY), torque(links, 0.0, (0.3, 0.0))])
        valid = np.ones(len(CLOCK), dtype=bool)
        motion = Motion(0.0, TS, q * times, v * times, a * times)
        listed.append(
            Run(str(seed), str(seed), motion, valid, TimeSeries(0.0, TS, effort * efforts, valid))
        )
    return listed


def test_slide_whose_force_and_position_are_negated_is_not_seen() -> None:
    """An offset carries the weight as well."""
    log = Log.of("run.csv", TS, *np.ones((2, 10, 3)), kinds=(LINEAR, ROTARY, ROTARY))
    base = base_of(f"{__file__}:LiftedLinks", None, log)
    assert mispaired(base, runs(np.array([-1.0, 1.0, 1.0]), np.array([-1.0, 1.0, 1.0]))) == ""


UNITS = {"degrees, not radians": 180 / np.pi, "radians, not degrees": np.pi / 180}


@pytest.mark.parametrize("text", UNITS)
def test_unit_of_all_angles_is_refused_where_another_axis_slides(text: str) -> None:
    log = Log.of("run.csv", TS, *np.ones((2, 10, 3)), kinds=(LINEAR, ROTARY, ROTARY))
    base = base_of(f"{__file__}:LiftedLinks", None, log)
    assert mispaired(base, runs(np.ones(3))) == ""
    times = UNITS[text]
    assert f"angles taken as {text}" in mispaired(base, runs(np.array([1.0, times, times])))
