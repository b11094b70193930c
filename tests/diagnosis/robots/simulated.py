"""A six-axis arm in MuJoCo, under control of its own: runs with friction that its file lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Change = Callable[[mujoco.MjModel], None]
FILE = Path(__file__).with_name("arm.urdf")
N, STEP, EVERY, SECONDS = 6, 5e-4, 4, 10.0
ENCODER, TORQUE = 2e-6, 2e-3
"""Noise of angles [rad], and of torques relative to their range."""
STIFF, DAMPED = np.array([4e3, 4e3, 2e3, 600.0, 300.0, 60.0]), 0.03
"""Feedback [N m/rad], and its derivative time [s]."""
DRY = (0.0, 0.0, 2.5, 0.0, 0.0, 0.0)
"""Friction of each axis [N m]."""
MISTAKE = 0.03
"""Masses and inertias of the machine differ so much from its file."""


def as_it_is(model: mujoco.MjModel) -> None:
    """Nothing more than the file does not say."""


def machine(friction: Sequence[float], change: Change = as_it_is) -> mujoco.MjModel:
    """The machine itself, heavier and lighter than its file, with rotors."""
    model, rng = mujoco.MjModel.from_xml_path(str(FILE)), np.random.default_rng(5)
    model.opt.timestep = STEP
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    wrong = 1 + MISTAKE * rng.standard_normal(model.nbody)
    model.body_mass *= wrong
    model.body_inertia *= wrong[:, None]
    model.dof_armature[:] = (0.5, 0.8, 0.3, 0.05, 0.03, 0.01)
    model.dof_frictionloss[:] = friction
    change(model)
    return model


def wanted(t: Array, seed: int) -> tuple[Array, Array, Array]:
    """Angles, rates and accelerations (samples, 6): sums of sines that begin at rest."""
    rng, n = np.random.default_rng(seed), 4
    w = 2 * np.pi * rng.uniform(0.1, 0.9, (n, N))
    size, phase = 0.7 / n / np.sqrt(w), rng.uniform(0, 2 * np.pi, (n, N))
    x = w * t[:, None, None] + phase
    waves = size * np.sin(x), size * w * np.cos(x), -size * w**2 * np.sin(x)
    q, v, a = (wave.sum(axis=1) for wave in waves)
    return q + np.array([0.0, 0.5, 0.8, 0.0, 0.4, 0.0]), v, a


def simulated(
    seed: int, number: int, friction: Sequence[float] = DRY, change: Change = as_it_is
) -> tuple[Array, Array, Array]:
    """Time (samples,), angles and torques (samples, 6) of a pass along the motion `seed`."""
    model, rng = machine(friction, change), np.random.default_rng([seed, number])
    data, plan = mujoco.MjData(model), mujoco.MjData(model)
    clock = np.arange(round(SECONDS / STEP)) * STEP
    q, v, a = wanted(clock, seed)
    data.qpos[:], data.qvel[:] = q[0], v[0]
    reported, seen = np.empty((len(clock), N)), np.empty((len(clock), N))
    for k in range(len(clock)):
        plan.qpos[:], plan.qvel[:], plan.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, plan)
        off = q[k] - data.qpos + DAMPED * (v[k] - data.qvel)
        data.qfrc_applied[:] = plan.qfrc_inverse + STIFF * off
        seen[k], reported[k] = data.qpos, data.qfrc_applied
        mujoco.mj_step(model, data)
    # a torque acts over the step that follows its angle: half a step later on the mean
    theta = seen[::EVERY] + ENCODER * rng.standard_normal(seen[::EVERY].shape)
    tau = reported[::EVERY] + TORQUE * reported.std(axis=0) * rng.standard_normal(theta.shape)
    return clock[::EVERY], theta, tau


def write(
    path: Path,
    seed: int,
    number: int,
    friction: Sequence[float] = DRY,
    change: Change = as_it_is,
    noise: float = 0.0,
) -> Path:
    """One run as CSV; noise of the torques, relative to their range, beside `TORQUE`."""
    t, theta, tau = simulated(seed, number, friction, change)
    rng = np.random.default_rng([seed, number, 1])
    tau = tau + noise * tau.std(axis=0) * rng.standard_normal(tau.shape)
    names = [f"{name}[{i + 1}]" for name in ("theta", "tau_meas") for i in range(N)]
    head = f"# trajectory: {seed}\n# pass: {number}\ntime,{','.join(names)}\n"
    with path.open("w") as file:
        file.write(f"{head}s{',rad' * N}{',N m' * N}\n")
        np.savetxt(file, np.column_stack([t, theta, tau]), delimiter=",", fmt="%.9g")
    return path
