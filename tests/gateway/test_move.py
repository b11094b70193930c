"""`move`: from pose to pose of a machine with weight, by feedback alone, and back to rest."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench
from tests.gateway.test_readback import SHORT
from tests.gateway.weight import TS, free

HOLD = 1.0
MOVE = ("move", "--enable", "--lockstep", "--hold", HOLD)
FIRST, SECOND = (0.1, 0.1, 0.1, 0.1, 0.1, 0.1), (-0.05, 0.0, 0.05, 0.0, -0.05, 0.02)


def written(pose: tuple[float, ...]) -> str:
    """A pose on the command line."""
    return ",".join(map(str, pose))


def test_machine_moves_through_poses_and_lands(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The FMUs are not used: one that fails at once changes nothing."""
    bad = spoiled(hexapod_ssp, Spoil("feedback", 1, "error"), tmp_path / "bad.ssp")
    command = (*MOVE, "--to", written(FIRST), "--to", written(SECOND), "--axis", 3, "--by", 0.02)
    fallen = free(Bench(bad, tmp_path), plant=hexapod_ssp, command=command)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    assert "done, drives disabled" in ran.words
    fallen.ends_at_rest(0)
    assert fallen.speed.max() < 0.4, "at most 0.25 rad/s are planned"
    assert np.abs(fallen.theta[-1] - fallen.theta[0]).max() < 0.02, "it ends where it rested"
    nudged = (*SECOND[:2], SECOND[2] + 0.02, *SECOND[3:])
    stood = [e for e in ran.events if e["event"] == "pose"]
    assert [tuple(e["pose"]) for e in stood] == [FIRST, SECOND, nudged, SECOND]
    for e in stood:
        assert np.abs(np.subtract(e["theta"], e["pose"])).max() < 1e-3
        assert e["cycles"] == round(HOLD / 2 / TS) + 1
    # it says so as soon as it is there, not only at the end
    arrived = [e for e in ran.events if e["event"] == "arrived"]
    assert [tuple(e["pose"]) for e in arrived] == [FIRST, SECOND, nudged, SECOND]
    for e in arrived:
        assert np.abs(np.subtract(e["theta"], e["pose"])).max() < 2e-3
    order = [e["event"] for e in ran.events if e["event"] in ("arrived", "phase", "summary")]
    assert order == ["phase", *4 * ["arrived"], *2 * ["phase"], "summary"]
    # the same pose takes the same torque, from wherever it is reached
    again = np.subtract(stood[1]["tau_meas"], stood[3]["tau_meas"])
    assert np.abs(again).max() < 0.05
    assert np.abs(stood[0]["tau_meas"]).max() > 0.3, "it carries its weight"
    # a new pose begins without a step of the torque
    assert np.abs(np.diff(fallen.tau, axis=0)).max() < 0.1


def test_ctrl_c_lands_from_a_pose(hexapod_ssp: Path, tmp_path: Path) -> None:
    def stop(gateway: object) -> None:
        lines = iter(gateway.stdout)  # type: ignore[attr-defined]
        assert any('"event":"moving"' in line for line in lines)
        os.kill(gateway.pid, signal.SIGINT)  # type: ignore[attr-defined]

    command = ("move", "--enable", "--lockstep", "--hold", 3000)
    fallen = free(Bench(hexapod_ssp, tmp_path), command=command, during=stop)
    assert fallen.ran.code == 0, fallen.ran.words
    assert "stopped on request, drives disabled" in fallen.ran.words
    fallen.ends_at_rest(0)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--to", "0.6,0,0,0,0,0"), "axis 1: 0.6 rad, allowed -0.52 to 0.52 rad"),
        (("--axis", 9, "--by", 0.1), "--axis 9: allowed 1 to 6"),
        (("--to", "1,2"), "write 6 angles in rad"),
    ],
)
def test_poses_that_cannot_be_taken_are_refused(
    words: tuple[object, ...], why: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=(*MOVE, *words), seconds=SHORT)
    assert ran.code == 2
    assert why in ran.one("refused")["message"]
    assert not ran.happened("state"), "not one frame was sent"


def test_blocked_axis_is_landed(hexapod_ssp: Path, tmp_path: Path) -> None:
    """An encoder that jumps on the way."""
    fault = '[[fault]]\ncycle = 9000\nkind = "encoder_jump"\nposition = 1\n'
    fallen = free(Bench(hexapod_ssp, tmp_path), fault, command=(*MOVE, "--to", written(FIRST)))
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["axis"], trip["reaction"]) == ("jump", 2, "damp")
    fallen.ends_at_rest(0)
