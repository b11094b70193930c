"""Brakes of the stops of a motion, judged before power: their torques, and where they end."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.test_singular import (
    BEGIN_S,
    BRAKE_S,
    JUDGED_S,
    Way,
    lands,
    played,
    profile,
    refused,
    stop,
)
from tests.gateway.weight import TS
from tests.oracles.actuator import chi
from tests.oracles.calculus import Array
from tests.oracles.lagrange import torque
from tests.oracles.machine import read_machine


def test_run_is_refused_whose_stop_needs_more_torque_than_a_landing_gives(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The torque of the brake by an independent model, of a motion that ended on a stop before."""
    way = ((-1, 1, 1, -1, 1, -1), 0.49, 0.48)
    time, at, message = refused(hexapod_ssp, tmp_path, way)
    axis, needed = re.search(r"axis (\d) needs ([\d.]+) N m to brake", message).groups()  # type: ignore[union-attr]
    assert "allowed 6 (landing.torque_N_m)" in message
    angles, rates, _ = profile(way, time)
    s = np.linspace(0, 1, 4001)
    share = s - s**3 + s**4 / 2
    k = int(np.abs(angles[0] + rates[0] * BRAKE_S * share - at[0]).argmin())
    there, thetad = angles + rates * BRAKE_S * share[k], rates * (1 - 3 * s[k] ** 2 + 2 * s[k] ** 3)
    thetadd, machine = rates * 6 * (s[k] ** 2 - s[k]) / BRAKE_S, read_machine()
    drives = chi(machine.actuator, there, thetad, np.sign(rates))
    expected = (torque(machine, there, thetad, thetadd) + drives)[int(axis) - 1]
    # the message has three digits of the angles, by which the phase of the brake is found
    assert float(needed) == pytest.approx(abs(expected), abs=0.1)
    assert float(needed) > 6.0


ALL_UP = (1, 1, 1, 1, 1, 1)


def soonest(way: Way, t: float, most: float) -> Array:
    """Where the hardest brake of a landing ends: its torque half-way by an independent model."""
    machine = read_machine()
    angles, rates, _ = profile(way, t)

    def needed(time: float) -> float:
        drives = chi(machine.actuator, angles, rates / 2, np.sign(rates))
        tau = torque(machine, angles, rates / 2, -1.5 * rates / time) + drives
        return float(np.abs(tau).max())

    short, long = 0.001, BRAKE_S
    while long - short > TS / 4:
        middle = (short + long) / 2
        short, long = (middle, long) if needed(middle) > most else (short, middle)
    return np.asarray(angles + rates * long / 2)


def test_run_is_refused_of_which_no_brake_ends_within_the_limits(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """All axes up together, farther than they may: no torque of a landing is enough."""
    way, limit = (ALL_UP, 0.515, 1.2), 0.4
    changes = (("position_max_rad = 0.52", f"position_max_rad = {limit}"),)
    time, _, message = refused(hexapod_ssp, tmp_path, way, changes=changes)
    angle = float(re.search(r"would come to rest at ([\d.]+) rad", message)[1])  # type: ignore[index]
    assert f"allowed -0.52 to {limit} (position_min_rad, position_max_rad)" in message
    stops = [soonest(way, t, 6.0)[0] for t in (time, time - JUDGED_S)]
    assert angle == pytest.approx(stops[0], abs=1e-3)
    assert stops[0] > limit > stops[1]


@pytest.mark.sample(1)
@pytest.mark.parametrize("seconds", [0.6, 0.62, 0.64])
def test_motion_towards_its_limits_is_landed_by_a_shorter_brake(
    seconds: float, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """To 5 mrad before its limit: the usual brake would end beyond it."""
    way = (ALL_UP, 0.515, 0.6)
    fallen = played(hexapod_ssp, tmp_path, way, seconds=seconds)
    assert fallen.ran.code == 0, fallen.ran.words
    assert stop(way, seconds - BEGIN_S)[0][0] < 0.52 < sum(stop(way, seconds - BEGIN_S))[0]
    assert all(time < BRAKE_S for time in fallen.ran.one("summary")["brakes_s"])
    assert fallen.ran.one("summary")["passed_limits"] == [False] * 6
    lands(fallen)
