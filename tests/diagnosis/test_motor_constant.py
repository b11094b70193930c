"""A wrong motor constant of an elbow makes its link seem heavy: the shoulder alone shows it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.found import read_diagnosis
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis import two_links
from tests.diagnosis.lwa4p import Link, write
from tests.diagnosis.synthetic import plain_csv

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

TIMES = 1.15
"""What the drive of the elbow reports, of the torque that the joint gets."""
COULOMB, VISCOUS = np.array([0.6, 0.3]), np.array([0.5, 0.2])


@pytest.fixture
def weighed(tmp_path: Path) -> str:
    """A base model of which only the masses are off, by one percent."""
    links = [
        Link((at, 0.0, 0.0), (0.0, 0.0, 0.0), times * m, (c, 0.0, 0.0), thick=(inertia / m) ** 0.5)
        for at, times, (m, c, inertia) in zip(
            (0.0, two_links.L1), (1.01, 0.99), two_links.BODIES, strict=True
        )
    ]
    known = "[tolerance]\nmass = 0.03\ninertia = 0.1\ncentre = 0.02\n"
    return str(write(tmp_path, links, (0.0, -two_links.G, 0.0), known))


def test_motor_constant_is_named_where_it_is(weighed: str, tmp_path: Path) -> None:
    """Beside friction that gains a hundred times as much, whose form may be a little wrong."""
    paths = []
    for motion in (1, 2, 3):
        for number in (1, 2):
            run = two_links.run(motion, number, 0.0, (0.0, 0.0))
            rate = two_links.moved(run["time"], motion)[1]
            run["tau_meas"] += COULOMB * np.tanh(rate / 0.01) + VISCOUS * rate
            run["tau_meas"][:, 1] *= TIMES
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    found = diagnose(paths, options=Options(base=weighed))
    axes = {effect.id: effect.axes for effect in found.effects}
    assert axes == {"coulomb_friction": (1, 2), "viscous_friction": (1, 2), "drive_gain": (2,)}
    values = {name: v.value for e in found.effects for name, v in e.parameters.items()}
    assert values["g"] == pytest.approx(1 - 1 / TIMES, abs=0.004)
    # of the joints, not as the drive reports it
    for axis in (1, 2):
        assert values[f"F_c[{axis}]"] == pytest.approx(COULOMB[axis - 1], rel=0.02)
        assert values[f"d_v[{axis}]"] == pytest.approx(VISCOUS[axis - 1], rel=0.02)
    more = read_diagnosis(_written(found, tmp_path / "diagnosis.json"))
    identified = identify(paths, options=Options(base=weighed), more=more)
    named = {one.name: one.estimate.value for one in identified.parameters}
    assert named["drive_gain.g[2]"] == pytest.approx(1 - 1 / TIMES, abs=0.002)
    assert named["F_c[2]"] == pytest.approx(COULOMB[1], rel=0.01)
    assert identified.simulation is not None
    assert not identified.simulation.left_out


def _written(found: Diagnosis, path: Path) -> Path:
    path.write_text(json.dumps(found.data()))
    return path
