"""Gears that do not turn evenly: an arm's links move as is wanted, and its motors turn by as much
more as an error of their gears asks for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.result.verdict import Diagnosis
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads import answer
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
ROTORS = np.array([0.4, 0.15])
"""Inertia of the motors behind their gears [kg m2]."""
several = pytest.mark.sample(2, of="gears that do not turn evenly")
__all__ = ["planar"]


def run(seed: int, number: int, sizes: Array, order: float, rubbed: float) -> dict[str, Array]:
    """time, theta, tau_meas of a pass of the motion `seed`; sizes (2,) [rad] of an error with that
    order, a cosine's; rubbed: viscous friction of the first motor [N m s/rad]."""
    t = np.arange(round(two_links.SECONDS / two_links.TS)) * two_links.TS
    rng, motion = np.random.default_rng([seed, number]), two_links.moved(t, seed)
    angle, rate, pace = motion
    phase, size = order * angle, order * sizes
    slope, bend = -size * np.sin(phase), -order * size * np.cos(phase)
    motor = (1 + slope) * pace + bend * rate**2
    # the power that enters a gear leaves it
    tau = two_links.torque(motion, 0.0, (0.0, 0.0)) / (1 + slope) + ROTORS * motor
    tau[:, 0] += rubbed * ((1 + slope) * rate)[:, 0]
    theta = angle + sizes * np.cos(phase) + 2e-6 * rng.standard_normal(angle.shape)
    return {"time": t, "theta": theta, "tau_meas": tau + 0.02 * rng.standard_normal(tau.shape)}


def diagnosed(folder: Path, base: str, sizes: Array, order: float, rubbed: float) -> Diagnosis:
    """The answer for two motions, three passes each."""
    paths = []
    for motion in (1, 2):
        for number in (1, 2, 3):
            log = run(motion, number, sizes, order, rubbed)
            more = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", log, **more))
    return answer(paths, base=base)


@several
@pytest.mark.parametrize(
    ("axis", "order", "size"),
    [(1, 40.0, 2e-4), (2, 40.0, 2e-4), (1, 202.0, 1e-5), (2, 202.0, 2e-5)],
    ids=["first", "second", "fine on the first", "fine on the second"],
)
def test_error_of_a_gear_is_named_with_its_size(
    axis: int, order: float, size: float, planar: str, tmp_path: Path
) -> None:
    sizes = np.where(np.arange(2) == axis - 1, size, 0.0)
    diagnosis = diagnosed(tmp_path, planar, sizes, order, 0.0)
    (effect,) = diagnosis.effects
    assert (effect.id, effect.axes) == ("transmission_error", (axis,))
    ((_, values),) = effect.parts
    for name, true in {"e_c": size, "e_s": 0.0, "order": order}.items():
        low, high = values[name].ci95
        assert low <= true <= high, name
    assert values["e_c"].ci95[1] < 1.5 * size


@several
def test_friction_of_its_motor_is_named_beside_it(planar: str, tmp_path: Path) -> None:
    diagnosis = diagnosed(tmp_path, planar, np.array([2e-4, 0.0]), 40.0, 0.3)
    assert {effect.id: effect.axes for effect in diagnosis.effects} == {
        "transmission_error": (1,),
        "viscous_friction": (1,),
    }


@several
def test_gears_that_turn_evenly_have_no_error(planar: str, tmp_path: Path) -> None:
    diagnosis = diagnosed(tmp_path, planar, np.zeros(2), 40.0, 0.3)
    assert [effect.id for effect in diagnosis.effects] == ["viscous_friction"]
