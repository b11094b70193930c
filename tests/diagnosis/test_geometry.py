"""Errors of geometry in the base models: their columns, and that nothing is left beside them."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.diagnosis.runs.smoothing import hann_weights
from studies.mujoco import machines
from studies.mujoco.engines import _arm
from studies.mujoco.machine import Machine, mistaken, rotation, toml, triple
from studies.mujoco.model import compiled, inverse
from tests.compare import assert_close
from tests.diagnosis.lwa4p import ARM, GRAVITY, TS, base_for, write

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

Array = NDArray[np.float64]
STEP = 1e-5
SAMPLES = csr_array(eye_array(5))
SECONDS, ENCODER = 6.0, 3e-5
ERRORS = (
    *("gravity.x", "gravity.y", "link_2.x", "link_3.y", "link_6.z"),
    *("link_2.pitch", "link_4.roll", "link_5.yaw"),
)


def angles(R: Array) -> tuple[float, float, float]:
    """Turns about fixed x, then y, then z that give a rotation."""
    z, y, x = np.arctan2(R[1, 0], R[0, 0]), np.arcsin(-R[2, 0]), np.arctan2(R[2, 1], R[2, 2])
    return float(x), float(y), float(z)


def displaced(folder: Path, name: str, by: float) -> RobotBase:
    """The arm with one error of geometry: a frame that is moved along or turned about its own axes,
    a foot that is turned about its own."""
    owner, _, what = name.partition(".")
    unit = np.eye(3)[("x", "y", "z", "roll", "pitch", "yaw").index(what) % 3]
    gravity, links = GRAVITY, list(ARM)
    if owner == "gravity":
        gravity = triple(rotation(triple(-by * unit)) @ np.array(GRAVITY))
    else:
        k = int(owner.removeprefix("link_")) - 1
        R = rotation(links[k].rpy)
        if what in "xyz":
            links[k] = replace(links[k], at=triple(np.array(links[k].at) + R @ (by * unit)))
        else:
            links[k] = replace(links[k], rpy=angles(R @ rotation(triple(by * unit))))
    return base_for(write(folder, links, gravity))


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", ERRORS)
def test_column_of_an_arm_is_the_difference_of_its_torques(name: str, tmp_path: Path) -> None:
    base, rng = base_for(write(tmp_path, ARM, GRAVITY)), np.random.default_rng(0)
    motion, p = Motion(0.0, TS, *rng.normal(size=(3, 5, 6))), rng.normal(size=66)
    assert base.geometry is not None
    columns = base.geometry.columns(motion, SAMPLES, p)
    at = [known.name for known in base.geometry.known].index(name)
    more, less = (displaced(tmp_path, name, by).rows(motion, SAMPLES) @ p for by in (STEP, -STEP))
    wanted = (more - less) / (2 * STEP)
    # differences of torques of some 50 N m, divided by 2e-5
    assert_close(columns[:, :, at], wanted, atol=1e-6 * np.abs(wanted).max())


def moved(n: int, number: int) -> Motion:
    """Sums of sines within a radian."""
    rng = np.random.default_rng(number)
    t = np.arange(0.0, SECONDS, TS)
    w, phase, size = (rng.uniform(a, b, (3, n)) for a, b in ((1, 5), (0, 6.28), (0.1, 0.3)))
    x = w * t[:, None, None] + phase
    waves = (size * np.sin(x), size * w * np.cos(x), -size * w**2 * np.sin(x))
    return Motion(0.0, TS, *(wave.sum(axis=1) for wave in waves))


def test_noise_of_the_angles_hardly_shows_in_the_columns(tmp_path: Path) -> None:
    base, clean = base_for(write(tmp_path, ARM, GRAVITY)), moved(6, 1)
    noisy = clean.theta + ENCODER * np.random.default_rng(3).standard_normal(clean.theta.shape)
    rates = np.gradient(noisy, TS, axis=0)
    seen = Motion(0.0, TS, noisy, rates, np.gradient(rates, TS, axis=0))
    at = np.arange(0.5, SECONDS - 0.5, base.spacing)
    valid = np.ones(len(noisy), dtype=bool)
    weights, _ = hann_weights(at, 0.0, TS, valid, base.window)
    p = np.array([known.nominal for known in base.linear])
    assert base.geometry is not None
    wanted, actual = (base.geometry.columns(motion, weights, p) for motion in (clean, seen))
    # accelerations of 3 rad/s2 RMS have a noise of 1.2 before they are smoothed, 0.05 after
    assert np.abs(actual - wanted).max() < 0.03 * np.abs(wanted).max()


def runs(machine: Machine) -> list[Run]:
    """Two passes of two trajectories with MuJoCo's torques and noise of 1e-4 of them."""
    model, listed, rng = compiled(machine, TS, ()), [], np.random.default_rng(7)
    for number in (1, 2):
        motion = moved(machine.n, number)
        tau = inverse(model, motion.theta, motion.thetad, motion.thetadd)
        for again in "ab":
            noisy = tau + 1e-4 * tau.std(axis=0) * rng.standard_normal(tau.shape)
            valid = np.ones(len(tau), dtype=bool)
            signal = TimeSeries(0.0, TS, noisy, valid)
            listed.append(Run(f"{number}{again}", str(number), motion, valid, signal))
    return listed


def left(base: Base, listed: Sequence[Run]) -> Array:
    """What the fit leaves of each axis' torque, relative RMS."""
    model = calibrate(base, blocks(base, listed, base.spacing))
    return axis_rms(model.blocks, model.residual(model.regression.q)) / model.torque_rms


def test_arm_whose_geometry_is_wrong_leaves_nothing() -> None:
    machine = machines.arm(np.random.default_rng(4))
    written = mistaken(machine, 0.0, 0.003, np.random.default_rng(5))
    listed = runs(machine)
    knows, firm = (
        _arm(tomllib.loads(toml(written, 0.01, geometry)), TS) for geometry in (0.003, 0.0)
    )
    # smoothing leaves a third of the noise, the rest is of second order in the errors
    assert left(knows, listed).max() < 2e-4
    assert left(firm, listed).max() > 1e-3
