"""`jog`: a person moves the machine by the keyboard, between lift-off and landing."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench
from tests.gateway.weight import Fallen, free

JOG = ("jog", "--enable", "--lockstep")


def jogged(bench: Bench, lines: str) -> Fallen:
    """A run with these lines on standard input."""

    def typed(gateway: subprocess.Popen[str]) -> None:
        assert gateway.stdin is not None
        gateway.stdin.write(lines)
        gateway.stdin.close()
        gateway.stdin = None

    return free(bench, command=JOG, during=typed, typing=True)


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
    for pose in ([0, 0, 0.05, 0, 0, 0], [0.1] * 6, [0.1, 0.1, 0.08, 0.1, 0.1, 0.1]):
        assert np.abs(fallen.theta - pose).max(axis=1).min() < 1e-3, pose
    fallen.ends_at_rest(0)
    assert fallen.speed.max() < 0.4
