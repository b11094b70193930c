"""The answer is the same whatever the torques: of a watch's motor or of a crane's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, wanted, write

OPTIONS = Options(base="axis")
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""Motion and pass; the last motion is judged on."""
CLOCK = np.arange(round(SECONDS / TS)) * TS
SATURATES = 0.02
"""Relative loss of the torque constant per N m that the drive reports."""


def said(folder: Path, scale: float, friction: float = 0.0, saturates: float = 0.0) -> Diagnosis:
    """The answer for torques larger by a factor."""
    folder.mkdir()
    paths = []
    for k, (motion, number) in enumerate(RUNS):
        torque = wanted(CLOCK, motion)
        # what is reported gives the torque after its loss: r (1 - s |r|) = tau
        reported = np.sign(torque) * (1 - np.sqrt(1 - 4 * saturates * np.abs(torque)))
        more = reported / (2 * saturates) - torque if saturates else 0.0
        path = folder / f"{k}.csv"
        paths.append(write(path, motion, number, friction, extra=more, scale=scale))
    return diagnose(paths[:4], paths[4:], options=OPTIONS)


@pytest.mark.sample(1)
@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
def test_friction_is_named_in_any_torque(scale: float, tmp_path: Path) -> None:
    (effect,) = said(tmp_path / "runs", scale, friction=0.12).effects
    assert effect.id == "coulomb_friction"
    assert effect.parameters["F_c"].value == pytest.approx(0.12 * scale, rel=0.05)


def test_saturation_is_named_alike_in_any_torque(tmp_path: Path) -> None:
    """Noise of the angles makes accelerations of half the torque here, unless it is smoothed."""
    losses = []
    for number, scale in enumerate([1.0, 1e-3, 1e3]):
        (effect,) = said(tmp_path / f"{number}", scale, saturates=SATURATES).effects
        assert (effect.id, effect.rivals) == ("torque_constant_saturation", ())
        losses.append(effect.parameters["s"].value * scale)
    assert losses == pytest.approx([SATURATES] * 3, rel=0.05)
    assert losses == pytest.approx([losses[0]] * 3, rel=1e-4)
