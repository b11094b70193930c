"""Joints that give way between a motor, whose angle is logged, and the link: an arm's links move as
is wanted, and its motors turn by as much more as their springs ask for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.result.verdict import Diagnosis
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads import answer, several
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
ROTORS = np.array([0.4, 0.15])
"""Inertia of the motors behind their gears [kg m2]."""
NOISY = 0.1
"""Noise of torques that makes most of what their second derivative is in a slow motion [N m]."""
__all__ = ["planar"]


SWING, SHAKEN = 2 * np.pi * 9.0, 4e-4
"""Of a fast part of one motion [rad/s], [rad]."""


def run(
    seed: int, number: int, compliance: Array, noise: float = two_links.NOISE
) -> dict[str, Array]:
    """time, theta, tau_meas of a pass of the motion `seed`; compliance (2,) [rad/N m]; noise of the
    torques [N m]. With more than usual the second motion has a fast part."""
    t = np.arange(round(two_links.SECONDS / two_links.TS)) * two_links.TS
    rng = np.random.default_rng([seed, number])
    motion = two_links.moved(t, seed)
    if noise > two_links.NOISE and seed == 2:
        motion = shaken(t, motion)
    passed = two_links.torque(motion, 0.0, (0.0, 0.0))
    bent = compliance * passed
    rate = np.gradient(np.gradient(bent, two_links.TS, axis=0), two_links.TS, axis=0)
    tau = passed + ROTORS * (motion[2] + rate)
    theta = motion[0] + bent + 2e-6 * rng.standard_normal(bent.shape)
    tau = tau + noise * rng.standard_normal(tau.shape)
    return {"time": t, "theta": theta, "tau_meas": tau}


def shaken(t: Array, motion: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """A motion with a fast part, the second axis against the first."""
    x, way = SWING * t[:, None], SHAKEN * np.array([1.0, -1.0])
    fast = way * np.sin(x), way * SWING * np.cos(x), -way * SWING**2 * np.sin(x)
    theta, rate, acceleration = (a + b for a, b in zip(motion, fast, strict=True))
    return theta, rate, acceleration


def diagnosed(
    folder: Path, base: str, *compliance: float, noise: float = two_links.NOISE
) -> Diagnosis:
    """The answer for two motions, three passes each."""
    paths = []
    for motion in (1, 2):
        for number in (1, 2, 3):
            log = run(motion, number, np.array(compliance), noise)
            more = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", log, **more))
    return answer(paths, base=base)


@several
@pytest.mark.parametrize("axis", [1, 2])
def test_elastic_joint_is_named_with_its_compliance(axis: int, planar: str, tmp_path: Path) -> None:
    c = (4e-4, 5e-3)[axis - 1]
    diagnosis = diagnosed(tmp_path, planar, *(c if k == axis else 0.0 for k in (1, 2)))
    (effect,) = diagnosis.effects
    assert (effect.id, effect.axes) == ("joint_elasticity", (axis,))
    ((_, values),) = effect.parts
    low, high = values["c"].ci95
    assert low <= c <= high


@several
def test_noise_of_one_motion_does_not_deny_what_the_other_shows(
    planar: str, tmp_path: Path
) -> None:
    c = 4e-4
    diagnosis = diagnosed(tmp_path, planar, c, 0.0, noise=NOISY)
    (effect,) = diagnosis.effects
    assert (effect.id, effect.axes) == ("joint_elasticity", (1,))
    ((_, values),) = effect.parts
    low, high = values["c"].ci95
    assert low <= c <= high


@several
def test_stiff_joints_have_no_elasticity(planar: str, tmp_path: Path) -> None:
    assert not diagnosed(tmp_path, planar, 0.0, 0.0).effects
