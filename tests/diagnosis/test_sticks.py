"""An axis that sticks at each reversal while its feedback turns the torque to the other side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.runs.rests import sticking
from flexhex.diagnosis.workflow import Options, diagnose

Array = NDArray[np.float64]
TS, SECONDS, STEP = 1e-3, 12.0, 5e-6
"""Sample, length of a run [s]; step of the encoder [rad]."""
J, WEIGHT, FRICTION, NOISE = 0.08, 1.4, 0.4, 0.01
HOLD = 0.04
"""Time of a stick [s]."""


def turning(amplitude: float, pace: float, hold: float) -> tuple[Array, Array, Array, Array]:
    """theta, thetad, thetadd (samples,) of a sine that stands still for `hold` [s] at each of its
    extremes, and dry friction relative to its size: turned over evenly meanwhile."""
    clock = np.arange(round(SECONDS / TS)) * TS
    half = np.pi / pace
    count, late = np.divmod(clock + half / 2, half + hold)
    stuck = late > half
    phase = pace * (np.minimum(late, half) - half / 2 + count * half)
    theta, rate, faster = np.sin(phase), pace * np.cos(phase), -(pace**2) * np.sin(phase)
    way = (-1.0) ** count
    dry = way * np.where(stuck, 1 - 2 * (late - half) / max(hold, TS), 1.0)
    moves = ~stuck
    return amplitude * theta, amplitude * rate * moves, amplitude * faster * moves, dry


def write(path: Path, motion: int, number: int, hold: float = HOLD, step: float = STEP) -> Path:
    """A run of one of three sines in the tool's format."""
    rng = np.random.default_rng([motion, number])
    theta, rate, faster, dry = turning(0.5 + 0.2 * motion, 4.0 + 1.3 * motion, hold)
    tau = J * faster + WEIGHT * np.sin(theta) + FRICTION * dry + 0.05 * rate
    tau += NOISE * rng.standard_normal(len(tau))
    rows = np.column_stack([np.arange(len(tau)) * TS, step * np.round(theta / step), tau])
    head = f"# trajectory: {motion}\n# pass: {number}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
    np.savetxt(path, rows, "%.8f", ",", header=head, comments="")
    return path


@pytest.mark.parametrize(("hold", "share"), [(0.0, 0.0), (HOLD, 1.0)])
def test_axis_that_only_turns_does_not_stick(hold: float, share: float) -> None:
    theta, *_ = turning(0.7, 5.3, hold)
    motion = Motion(0.0, TS, theta[:, None], theta[:, None], theta[:, None], noise=np.array([1e-6]))
    stuck = sticking(motion, np.array([0.7 * 5.3**2 / 2**0.5]), 0.025)[:, 0]
    held = np.flatnonzero(np.diff(theta) == 0) + 1
    assert stuck[held].mean() == share if hold else not stuck.any()
    assert stuck.sum() <= 1.3 * len(held)


def test_axis_that_creeps_through_its_turn_sticks() -> None:
    """As friction grows with the rate, be it in presliding or in a simulator, it shows small ways
    while its torque turns over."""
    theta, *_ = turning(0.7, 5.3, HOLD)
    held = np.diff(theta, append=theta[-1]) == 0
    creep = np.cumsum(np.where(held, 1e-3 * TS, 0.0))
    noise, pace = np.array([1e-7]), np.array([0.7 * 5.3**2 / 2**0.5])
    angle = (theta + creep)[:, None]
    motion = Motion(0.0, TS, angle, angle, angle, noise=noise)
    assert sticking(motion, pace, 0.025)[held].mean() > 0.95
    calm = turning(0.7, 5.3, 0.0)[0][:, None]
    assert not sticking(Motion(0.0, TS, calm, calm, calm, noise=noise), pace, 0.025).any()


def test_what_friction_holds_at_a_reversal_is_no_error_of_its_form(tmp_path: Path) -> None:
    paths = [write(tmp_path / f"{k}_{n}.csv", k, n) for k in (1, 2, 3) for n in (1, 2)]
    found = diagnose(paths[:4], paths[4:], options=Options("axis"))
    names = {(e.id, e.axes) for e in found.effects}
    assert names >= {("coulomb_friction", (1,))}
    assert found.residual.held_out["after"][0] < 2 * NOISE
    (force,) = (v for e in found.effects for k, v in e.parameters.items() if k.startswith("F_c"))
    assert force.value == pytest.approx(FRICTION, rel=0.02)


def test_friction_turns_in_the_middle_of_a_short_stick(tmp_path: Path) -> None:
    """Of a few samples, in which the angle shows one step of the encoder: it is as large as it is,
    and no delay."""
    listed = [(k, n) for k in (1, 2, 3) for n in (1, 2)]
    paths = [write(tmp_path / f"{k}_{n}.csv", k, n, 0.01, 2.5e-5) for k, n in listed]
    found = diagnose(paths[:4], paths[4:], options=Options("axis"))
    assert [(e.id, e.axes) for e in found.effects] == [("coulomb_friction", (1,))]
    low, high = found.effects[0].parameters["F_c"].ci95
    assert low < FRICTION < high
    assert found.effects[0].parameters["F_c"].value == pytest.approx(FRICTION, rel=0.005)
    assert not [text for text in found.findings if "angles by" in text]
    assert not found.remains
