"""A spring and a constant torque on a joint of an arm, whose base model has neither."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.result.verdict import Estimate
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


def test_nothing_is_a_spring_where_there_is_none(planar: str, tmp_path: Path) -> None:
    assert diagnose(logs(tmp_path, np.zeros_like), options=Options(base=planar)).verdict == "none"


def test_spring_says_where_it_is_at_rest() -> None:
    values, units = {"o": -1.08, "k_1": 1.2}, {"o": "N m", "k_1": "N m/rad"}
    assert library()["linear_stiffness"].meaning(values, units) == "no torque at 0.9 rad"
