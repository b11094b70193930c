"""A spring and a constant torque on a joint of an arm, whose base model has neither."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.jointfit.guess import first_guess
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.prepare import run_set_of
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.span import spacing_for
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import library
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]

Array = NDArray[np.float64]
STIFFNESS, REST, OFFSET = 1.2, 0.9, 0.35
"""Of the spring [N m/rad], where it is at rest [rad]; a constant torque [N m]."""


def logs(folder: Path, torque: Callable[[Array], Array]) -> list[Path]:
    """Three motions, two passes each; the second joint needs a further torque of its angle."""
    paths = []
    for motion in (1, 2, 3):
        for number in (1, 2):
            run = two_links.run(motion, number, 0.0, (0.0, 0.0))
            angle = two_links.moved(run["time"], motion)[0][:, 1]
            run["tau_meas"][:, 1] += torque(angle)
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", run, **head))
    return paths


def within(estimate: Estimate, value: float) -> bool:
    low, high = estimate.ci95
    return low <= value <= high


def test_spring_of_a_joint_is_named_with_its_stiffness(planar: str, tmp_path: Path) -> None:
    paths = logs(tmp_path, lambda angle: STIFFNESS * (angle - REST))
    (effect,) = diagnose(paths, options=Options(base=planar)).effects
    assert (effect.id, effect.axes, effect.rivals) == ("linear_stiffness", (2,), ())
    assert within(effect.parameters["k_1"], STIFFNESS)
    assert within(effect.parameters["o"], -STIFFNESS * REST)


def test_constant_torque_is_no_spring(planar: str, tmp_path: Path) -> None:
    (effect,) = diagnose(logs(tmp_path, lambda angle: OFFSET), options=Options(base=planar)).effects
    assert (effect.id, effect.axes, effect.rivals) == ("torque_offset", (2,), ())
    assert within(effect.parameters["o"], OFFSET)


def test_ordinary_offset_of_a_torque_is_no_finding(planar: str, tmp_path: Path) -> None:
    """Sensors and currents have one, and nobody can tell it from the machine's: it is in the fit,
    so that nothing else stands in for it, and no name."""
    torque = np.concatenate([two_links.run(m, 1, 0.0, (0.0, 0.0))["tau_meas"] for m in (1, 2, 3)])
    offset = 0.02 * float(torque[:, 1].std())
    diagnosis = diagnose(logs(tmp_path, lambda angle: offset), options=Options(base=planar))
    assert diagnosis.verdict == "none"
    assert not diagnosis.effects
    (note,) = diagnosis.notes
    found = re.fullmatch(r"constant torque on axis 2, (\S+) N m: in the fit, but no more .*", note)
    assert found
    assert float(found[1]) == pytest.approx(offset, rel=0.1)


def test_nothing_is_a_spring_where_there_is_none(planar: str, tmp_path: Path) -> None:
    assert diagnose(logs(tmp_path, np.zeros_like), options=Options(base=planar)).verdict == "none"


def test_spring_says_where_it_is_at_rest() -> None:
    values, units = {"o": -1.08, "k_1": 1.2}, {"o": "N m", "k_1": "N m/rad"}
    assert library()["linear_stiffness"].meaning(values, units) == "no torque at 0.9 rad"


def test_constant_torque_beside_friction_bends_no_delay(planar: str, tmp_path: Path) -> None:
    """A constant torque as large as all others, and dry friction on the other joint: what neither
    the arm nor friction explains must not become a delay of the torques, or other masses."""
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        rate = two_links.moved(run["time"], motion)[1]
        run["tau_meas"] += [0.0, 6.0] + np.tanh(rate / 1e-3) * [2.0, 0.0]
        head = {"trajectory": str(motion), "pass": str(number)}
        paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    base, run_set, _ = run_set_of(paths, [], None, Options(base=planar))
    blocks_of = blocks(base, run_set.runs, spacing_for(base, run_set.runs))
    rough = first_guess(base, blocks_of, 0.01)
    assert rough[1] == 0.0
    model = calibrate(base, blocks_of)
    assert abs(model.fitted.delay) < 5e-4
    left = with_friction(model)
    remains = axis_rms(left.blocks, left.residual(left.regression.q))
    assert (remains < 0.2).all()
