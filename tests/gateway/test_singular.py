"""Motions towards a singular pose: refused before power, stopped where a landing still holds."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from flexhex.trajectory.variant import with_trajectory
from tests.conftest import MACHINE_FILE
from tests.gateway.bench import Bench, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.landing_twin import MOST
from tests.gateway.test_falls import POSE
from tests.gateway.test_workspace import ONE_UP, TWO_UP, gain
from tests.gateway.weight import STROKE, TS, Fallen, free
from tests.oracles.calculus import Array
from tests.oracles.geometry import close
from tests.oracles.machine import Machine, read_machine

Way = tuple[tuple[int, ...], float, float]
"""Signs, angle [rad], time [s] of a motion."""

BEGIN_S = 0.1
BRAKE_S, JUDGED_S = 0.1, 0.0125
"""Time of a brake, and from one stop that is judged to the next."""
REST = np.array([-0.236, -0.348, -0.235, -0.293, -0.250, -0.317])
"""Where the machine rests [rad]."""
NAME = "platform moves towards a singular pose"
UNJUDGED = ("torque_N_m = 6.0 ", "platform_gain = 1000.0\ntorque_N_m = 27.0 ")


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
    way: Way,
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


def profile(way: Way, t: float) -> tuple[Array, Array, Array]:
    """Angles, rates and accelerations (6,) of a motion, t after its begin."""
    signs, far, time = way
    s, size = t / time, far * np.array(signs)
    angles = size * s**3 * (10 - 15 * s + 6 * s * s)
    rates = size * 30 * s**2 * (1 - s) ** 2 / time
    return angles, rates, size * 60 * s * (1 - s) * (1 - 2 * s) / time**2


def refused(ssp: Path, folder: Path, way: Way, **more: object) -> tuple[float, Array, str]:
    """When after the begin of the motion, in which pose and why a run is not begun."""
    fallen = played(ssp, folder, way, seconds=5.0, **more)
    assert fallen.ran.code == 3, fallen.ran.words
    never_enabled(fallen.ran)
    message = str(fallen.ran.one("refused")["message"])
    time = float(re.search(r"the motion of the run, ([\d.]+) s after", message)[1])  # type: ignore[index]
    at = re.search(r"at (\[.*?\]) rad", message)
    return time - BEGIN_S, np.array(json.loads(at[1]) if at else []), message


@pytest.mark.parametrize(
    "way",
    [(TWO_UP, 0.50, 1.0), (TWO_UP, 0.50, 0.7), (ONE_UP, 0.345, 0.8)],
    ids=["two", "faster", "one"],
)
def test_run_is_refused_whose_stop_would_end_near_a_singular_pose(
    way: Way, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """All within the position limits; the gain at the end of the stop by an independent model."""
    time, at, message = refused(hexapod_ssp, tmp_path, way)
    assert "allowed 2 (landing.platform_gain): a singular pose is near" in message
    machine = read_machine()
    stops = [np.add(*stop(way, t)) for t in (time, time - JUDGED_S)]
    # the message has three digits
    assert np.allclose(at, stops[0], atol=2e-3)
    gains = [gain(machine, close(machine, stop)) for stop in stops]
    assert gains[0] > 2.0 > gains[1]
    told = float(re.search(r"moves the platform ([\d.]+) times", message)[1])  # type: ignore[index]
    assert told == pytest.approx(gains[0], abs=0.02)


def stop(way: Way, t: float) -> tuple[Array, Array]:
    """Angles, and the way of a stop from there: the mean rate of a brake is half of the first."""
    angles, rates, _ = profile(way, t)
    return angles, rates * BRAKE_S / 2


def test_run_is_refused_whose_motion_leaves_the_limits_of_the_pose(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """All axes up together raise the platform; the height by an independent model."""
    way = ((1, 1, 1, 1, 1, 1), 0.3, 1.0)
    time, at, message = refused(hexapod_ssp, tmp_path, way, changes=(POSE,))
    assert "x.x_E.z = 0.31" in message
    assert "allowed 0.28 to 0.315 ([[pose]]): correct the motion" in message
    assert np.allclose(at, profile(way, time)[0], atol=1e-3)
    heights = [close(read_machine(), profile(way, t)[0])[32] for t in (time, time - JUDGED_S)]
    assert heights[0] > 0.315 > heights[1]


def test_machine_that_goes_farther_than_its_motion_is_stopped_where_a_landing_still_holds(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Without the model's torques the axes overshoot a motion that is allowed."""
    way, machine = (TWO_UP, 0.44, 0.9), read_machine()
    ends = [np.add(*stop(way, t)) for t in np.linspace(0.3, 0.9, 25)]
    most = max(gain(machine, close(machine, end)) for end in ends) + 0.01
    changes = (
        ("torque_N_m = 6.0 ", f"platform_gain = {most:.3f}\ntorque_N_m = 6.0 "),
        ("\n[bus]", '\n[system.parameters]\n"feedback.ff_gain" = 0.0\n[bus]'),
        ("following_error_rad = 0.05", "following_error_rad = 0.3"),
    )
    fallen = played(hexapod_ssp, tmp_path, way, seconds=5.0, changes=changes)
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["reaction"], trip["axis"]) == ("singular", "land", None)
    assert trip["limit"] == pytest.approx(most, abs=1e-3)
    # it comes to rest where the gain is that limit, by some digits more or less
    told = fallen.ran.one("summary")["landing_trip"]
    assert told is None or told.startswith("a singular pose is near")
    fallen.ends_at_rest(began(fallen))
    assert fallen.ran.one("summary")["cycles_to_zero"] > 12_000
    falls.add(fallen.fall(NAME, 0))


def test_joint_limits_alone_do_not_cover_a_singular_pose(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Why there is a limit of the gain: slowly to where it is 8, without the limit."""
    fallen = played(hexapod_ssp, tmp_path, (TWO_UP, 0.50, 3.0), seconds=3.5, changes=(UNJUDGED,))
    assert fallen.ran.code == 1
    assert fallen.ran.one("summary")["passed_limits"] == [True, True, *[False] * 4]
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
    way: Way, seconds: float, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Up to a gain of 1.65."""
    fallen = played(hexapod_ssp, tmp_path, way, seconds=seconds)
    assert fallen.ran.code == 0 or fallen.ran.one("trip")["reason"] == "singular", fallen.ran.words
    lands(fallen)
    assert fallen.speed.max() < 1.05 * 1.875 * way[1] / way[2]
    assert TS * began(fallen) > seconds - BEGIN_S
