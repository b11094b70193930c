"""Motions towards a singular pose: stopped where a landing still holds, and landed at any time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.trajectory.variant import with_trajectory
from tests.conftest import MACHINE_FILE
from tests.gateway.bench import Bench
from tests.gateway.fault_table import Table
from tests.gateway.test_lift_off import MOST
from tests.gateway.test_workspace import ONE_UP, TWO_UP, gain
from tests.gateway.weight import STROKE, TS, Fallen, free
from tests.oracles.calculus import Array
from tests.oracles.geometry import close
from tests.oracles.machine import Machine, read_machine

BEGIN_S = 0.1
REST = np.array([-0.236, -0.348, -0.235, -0.293, -0.250, -0.317])
"""Where the machine rests [rad]."""
NAME = "platform moves towards a singular pose"
UNJUDGED = ("torque_N_m = 6.0 ", "platform_gain = 1000.0\ntorque_N_m = 6.0 ")


def motion(file: Path, signs: tuple[int, ...], far: float, time: float) -> Path:
    """From rest to rest, `far` [rad] away in the direction of the signs; it stays there."""
    t = np.linspace(0.0, time, 41)
    s = t / time
    share = np.append(s**3 * (10 - 15 * s + 6 * s * s), 1.0)
    rows = np.column_stack([np.append(t, time + 1.0), far * share[:, None] * np.array(signs)])
    names = ",".join(["time", *(f"r[{k}]" for k in range(1, 7))])
    np.savetxt(file, rows, delimiter=",", comments="", header=f"{names}\ns{',rad' * 6}")
    return file


def played(
    ssp: Path,
    folder: Path,
    way: tuple[tuple[int, ...], float, float],
    *,
    seconds: float,
    **more: object,
) -> Fallen:
    """A run along a motion: signs, angle, time."""
    file = motion(folder / "motion.csv", *way)
    variant = with_trajectory(ssp, file, MACHINE_FILE, folder, begin=BEGIN_S)
    return free(Bench(variant.path, folder), seconds=seconds, **more)  # type: ignore[arg-type]


def began(fallen: Fallen) -> int:
    """Cycle since enabling in which the landing began."""
    return int(fallen.ran.one("summary")["lifted"]) + int(fallen.ran.one("summary")["cycles"])


def lands(fallen: Fallen) -> None:
    """By feedback to the end: in its rest pose before the power is taken."""
    since = began(fallen)
    before = fallen.speed[: since - 8].max()
    assert fallen.speed[since:].max() < max(1.0, 1.05 * before), "braking begins there"
    assert np.abs(fallen.theta[since:]).max() < STROKE
    assert fallen.ran.one("summary")["not_disabled"] == []
    assert fallen.ran.one("summary")["landing_trip"] is None
    # three seconds and more after the cycle in which it stopped: a fall takes a third of one
    assert fallen.ran.one("summary")["cycles_to_zero"] > 12_000
    assert np.abs(fallen.tau[since + 1 :]).max() < MOST


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "way",
    [(TWO_UP, 0.50, 1.0), (TWO_UP, 0.50, 0.7), (ONE_UP, 0.345, 0.5)],
    ids=["two", "faster", "one"],
)
def test_run_stops_where_a_landing_still_holds(
    way: tuple[tuple[int, ...], float, float], hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """All within the position limits; without the rule the landing ends in a fall, below."""
    fallen = played(hexapod_ssp, tmp_path, way, seconds=5.0)
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["reaction"], trip["axis"]) == ("singular", "land", None)
    assert trip["limit"] == 2.0
    lands(fallen)
    if way == (TWO_UP, 0.50, 1.0):
        falls.add(fallen.fall(NAME, 0))


def test_joint_limits_alone_do_not_cover_a_singular_pose(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Why there is a rule: a run that is over where the gain is 2.7 cannot be landed."""
    fallen = played(hexapod_ssp, tmp_path, (TWO_UP, 0.50, 1.0), seconds=1.0, changes=(UNJUDGED,))
    assert fallen.ran.code == 1
    assert "following error" in fallen.ran.one("summary")["landing_trip"]
    assert np.abs(fallen.theta).max() > STROKE - 1e-3, "it fell onto its stops"


def test_way_to_rest_from_an_allowed_pose_has_no_larger_gain() -> None:
    """Poses drawn at random within the stroke; the gains by an independent model."""
    machine, chance = read_machine(), np.random.default_rng(19)
    poses = chance.uniform(-0.5, 0.5, (20, 6))
    allowed = [pose for pose in poses if reachable(machine, pose) < 2.0]
    assert len(allowed) > 5
    for pose in allowed:
        ways = [REST + share * (pose - REST) for share in np.linspace(0.0, 1.0, 12)]
        gains = [gain(machine, close(machine, at)) for at in ways]
        assert max(gains) <= max(gains[0], gains[-1]) * 1.001, pose


def reachable(machine: Machine, pose: Array) -> float:
    """The gain at a pose that is reached on the straight way from neutral; infinite elsewhere."""
    try:
        return max(gain(machine, close(machine, share * pose)) for share in np.linspace(0.1, 1, 10))
    except ArithmeticError:
        return np.inf


@pytest.mark.sample(2)
@pytest.mark.parametrize("way", [(TWO_UP, 0.44, 1.0), (ONE_UP, 0.30, 1.0)], ids=["two", "one"])
@pytest.mark.parametrize("seconds", [0.5, 0.7, 0.9, 1.1, 1.5])
def test_motion_that_is_allowed_lands_whenever_it_ends(
    way: tuple[tuple[int, ...], float, float], seconds: float, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Up to a gain of 1.65."""
    fallen = played(hexapod_ssp, tmp_path, way, seconds=seconds)
    assert fallen.ran.code == 0 or fallen.ran.one("trip")["reason"] == "singular", fallen.ran.words
    lands(fallen)
    assert fallen.speed.max() < 1.05 * 1.875 * way[1] / way[2]
    assert TS * began(fallen) > seconds - BEGIN_S
