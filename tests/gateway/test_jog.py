"""`jog`: a person moves the machine by the keyboard, between lift-off and landing."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench
from tests.gateway.weight import Fallen, free

JOG = ("jog", "--enable", "--lockstep")


def jogged(bench: Bench, lines: str, changes: Sequence[tuple[str, str]] = ()) -> Fallen:
    """A run with these lines on standard input."""

    def typed(gateway: subprocess.Popen[str]) -> None:
        assert gateway.stdin is not None
        gateway.stdin.write(lines)
        gateway.stdin.close()
        gateway.stdin = None

    return free(bench, command=JOG, during=typed, typing=True, changes=changes)


@pytest.mark.parametrize("end", ["q\n", ""])
def test_machine_moves_as_the_lines_say_and_lands(
    end: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    lines = "3 0.05\n3 9\n\nto 0.1,0.1,0.1,0.1,0.1,0.1\nwhat\n3 -0.02\n"
    fallen = jogged(Bench(hexapod_ssp, tmp_path), lines + end)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    assert "9 rad: allowed at most 0.05 rad" in ran.words
    assert "write `3 0.01`" in ran.words
    poses = ([0, 0, 0.05, 0, 0, 0], [0.1] * 6, [0.1, 0.1, 0.08, 0.1, 0.1, 0.1])
    for pose in poses:
        assert np.abs(fallen.theta - pose).max(axis=1).min() < 1e-3, pose
    # it says when it is there, also in the pose in which it begins, with what was measured
    arrived = [e for e in ran.events if e["event"] == "arrived"]
    assert np.allclose([e["pose"] for e in arrived], [[0] * 6, *poses], atol=1e-12)
    for e in arrived:
        there = np.abs(fallen.theta - e["theta"]).max(axis=1).min()
        off = np.subtract(e["theta"], e["pose"])
        assert there < 1e-9, "angles that the machine had"
        assert np.abs(off).max() < 1e-3
        assert off[e["axis"] - 1] == e["off_rad"], "the axis that is off most"
        assert abs(e["off_rad"]) == np.abs(off).max()
    assert ran.words.count("arrived") == len(arrived)
    assert [e["line"] for e in ran.events if e["event"] == "not_done"] == ["3 9", "what"]
    fallen.ends_at_rest(0)
    assert fallen.speed.max() < 0.4
