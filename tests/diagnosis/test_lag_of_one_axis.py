"""A lag of one drive is no delay of all torques."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.workflow import diagnose
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]
LAG = 0.006
"""Time constant of the drive [s]."""


def run(folder: Path, motion: int, number: int, axis: int) -> Path:
    """A pass of an arm whose drive of one axis (from 0) passes on its torque with a lag: reported
    is what is asked of it, tau + T tau'."""
    values = two_links.run(motion, number, 0.0, (0.0, 0.0))
    ideal = two_links.torque(two_links.moved(values["time"], motion), 0.0, (0.0, 0.0))
    values["tau_meas"][:, axis] += LAG * np.gradient(ideal[:, axis], two_links.TS)
    head = {"trajectory": str(motion), "pass": str(number)}
    return plain_csv(folder / f"{motion}{number}.csv", values, **head)


@pytest.mark.parametrize("axis", [0, 1])
def test_lag_of_one_drive_is_named(planar: str, tmp_path: Path, axis: int) -> None:
    paths = [run(tmp_path, motion, number, axis) for motion in (1, 2, 3) for number in (1, 2)]
    diagnosis = diagnose(paths, options=Options(base=planar))
    (effect,) = diagnosis.effects
    assert {effect.id, *effect.rivals} == {"drive_lag", "time_delay"}
    assert effect.axes == (axis + 1,)
    (value,) = effect.parameters.values()
    assert value.value == pytest.approx(LAG, rel=0.1)
