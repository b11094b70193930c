"""A foot that is not level: what tolerances of gravity and of places allow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.robots.simulated import DRY, FILE, N, write

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

LOG = Log.of("made", 1e-3, np.zeros((10, N)), np.zeros((10, N)))
TILT = 0.006


def tilted(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = 9.81 * np.array([0.0, np.sin(TILT), -np.cos(TILT)])


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> Sequence[Path]:
    """Two motions, each twice."""
    folder = tmp_path_factory.mktemp("tilted")
    return [
        write(folder / f"{s}_{k}.csv", s, k, DRY, tilted, noise=0.01)
        for s in (1, 2)
        for k in (1, 2)
    ]


def test_tilt_within_its_tolerance_is_told_with_its_torque(paths: Sequence[Path]) -> None:
    """Not bodies, nor places that only noise moves."""
    diagnosis = diagnose(paths, options=Options(base=str(FILE)))
    assert not diagnosis.changed
    (tilt,) = diagnosis.tolerated
    low, high = tilt.estimate.ci95
    assert (tilt.parameter, tilt.tolerance) == ("gravity.x", 0.002)
    assert low < TILT < high or low < -TILT < high
    assert 0.003 < tilt.share < 0.3


def test_narrower_tolerance_makes_a_tilt_a_change(paths: Sequence[Path]) -> None:
    options = Options(base=str(FILE), tolerance={"gravity": 0.0005})
    diagnosis = diagnose(paths, options=options)
    assert [changed.parameter for changed in diagnosis.changed] == ["gravity.x"]
    assert not diagnosis.tolerated


def names(base: Base) -> list[str]:
    return [known.name for known in base.geometry.known] if base.geometry else []


def test_gravity_and_places_have_a_tolerance_each() -> None:
    """No tolerance of one switches the other one off."""
    both = names(base_of(str(FILE), None, LOG))
    level = ["gravity.x", "gravity.y"]
    assert names(base_of(str(FILE), None, LOG, {"geometry": 0.0})) == level
    assert names(base_of(str(FILE), None, LOG, {"gravity": 0.0})) == both[2:]
    assert both[:2] == level
    assert base_of(str(FILE), None, LOG, {"gravity": 0.0, "geometry": 0.0}).geometry is None
