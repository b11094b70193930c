"""What an angle that is read wrongly does to all torques of a base model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.misread import Misread
from tests.diagnosis.test_common_delay import arm
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]
SMALL = 1e-6


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("order", [1.0, 4.0])
def test_errors_of_an_angle_add_up_from_what_its_signals_do(
    axis: int, order: float, planar: str, tmp_path: Path
) -> None:
    """As the torque changes where the angle and its derivatives are moved together; the slopes are
    those at the mean motion of each row, which makes an error of a thousandth here."""
    model = arm(tmp_path, planar, (0, 0))
    subject, block = Misread(model), model.blocks[0]
    motion, weights = block.run.motion, block.weights
    angle = np.sin(order * motion.theta[:, axis])
    rate = np.gradient(angle, motion.ts)
    pushes = angle, rate, np.gradient(rate, motion.ts)
    signals = motion.theta, motion.thetad, motion.thetadd
    one = np.eye(model.base.n)[axis]
    moved = [own + SMALL * push[:, None] * one for own, push in zip(signals, pushes, strict=True)]
    p = model.linear(block.run)
    there = replace(motion, theta=moved[0], thetad=moved[1], thetadd=moved[2])
    more = model.base.torque(there, p) - model.base.torque(motion, p)
    error = np.sin(order * block.run.motion.theta[:, [axis]])
    felt = subject.turned(0, axis, error)[:, :, 0]
    np.testing.assert_allclose(
        felt, -(weights @ more) / SMALL, rtol=0, atol=2e-3 * np.abs(felt).max()
    )


def test_a_closure_is_solved_for_angles_that_are_others_alone() -> None:
    solved = list[Motion]()

    def torque(motion: Motion, p: Any) -> NDArray[np.float64]:
        if "closure" not in motion.solved:
            solved.append(motion)
        return motion.solved.setdefault("closure", motion.theta)

    run: Any = SimpleNamespace(base=SimpleNamespace(torque=torque), linear=lambda run: None)
    run.blocks = [SimpleNamespace(run=None)]
    subject = Misread(run)
    vars(subject)["motions"] = [Motion(0.0, 1e-3, *np.ones((3, 5, 2)))]
    subject._slopes_of(1)
    assert len(solved) == 2
