"""The command by which the machine was tuned, and what its tuning has to reach."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.sections import Body
from flexhex.simulation.metrics import KEYS
from results.record import FOLDER
from studies.fidelity import WITHIN, Trajectory, deviations, extents, main, sense


def test_deviation_is_of_the_mean_square() -> None:
    """Rows of 3 and 4 have an RMS of sqrt(12.5)."""
    result = deviations([[3.0, 1.0], [4.0, 1.0]], [12.5**0.5, 2.0])
    assert result == pytest.approx([0.0, -0.5], abs=1e-15)


def test_extents_are_those_of_points() -> None:
    """Masses of 1 kg at +-1 m on x, +-2 m on y, +-3 m on z about their centre."""
    square = 2 * np.array([1.0, 4.0, 9.0])
    moments = square.sum() - square
    body = Body.model_construct(m=6.0, c=(0.1, 0.2, 0.3), Ic=(*moments, 0.0, 0.0, 0.0))
    assert extents(body) == pytest.approx(np.sqrt(square / 6.0))


def test_bounds_are_the_machines_own(machine: Machine) -> None:
    runs = [Trajectory((), 0.2, 3.0, False), Trajectory((), 0.1, 4.0, True)]
    result = sense(machine, runs)
    assert result["angle [rad]"] == (0.2, machine.geometry.stroke)
    assert result["torque [N m]"] == (4.0, machine.drive.tau_max)
    assert result["end stops reached"] == (1.0, 0.0)
    extent, joints = result["end-effector extent [m]"]
    assert 0 < extent < joints < 0.3


def test_recorded_row_is_the_published_one() -> None:
    """All eight columns with feedback only, as recorded from the simulated machine."""
    data = json.loads((FOLDER / "paper.json").read_text(encoding="utf-8"))["results"]
    row = [data["cases"]["feedback"][key] for key in KEYS]
    assert np.abs(deviations([row], data["paper"]["feedback"])).max() < WITHIN


def test_command_prints_columns_and_bounds(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A short trajectory has other figures: only their number and the verdict's form are tested."""
    code = main(["--duration", "2", "--seeds", "4", "--json", "--out", str(tmp_path)])
    data = json.loads(capsys.readouterr().out)
    assert [len(row) for row in data["rows"]] == [len(KEYS)]
    assert code == int(np.abs(data["deviations"]).max() > WITHIN)


def test_mistakes_are_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["machines/absent.toml"]) == 3
    assert "machines/absent.toml" in capsys.readouterr().err
