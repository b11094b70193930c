"""What an angle that is read wrongly does to all torques of a base model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

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
