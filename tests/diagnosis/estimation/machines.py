"""Machines whose parameters are to be found, their torques by MuJoCo or by textbook equations; the
friction and the noise are written here."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TS, SECONDS, NOISE = 2e-3, 10.0, 0.005
SHARP = 0.02
"""Rate within which dry friction turns over, relative to the RMS rate."""
CART = """<mujoco><compiler angle="radian"/><worldbody><body name="cart">
<joint name="rail" type="slide" axis="1 0 .2"/>
<inertial pos="0 0 .1" mass="8" diaginertia=".1 .1 .1"/>
<body name="arm" pos="0 .2 0"><joint name="a" type="hinge" axis="0 1 0" pos=".02 0 0"/>
<inertial pos=".1 .02 -.2" mass="3" diaginertia=".03 .03 .01"/>
<body name="wrist" pos=".1 0 -.3" euler=".3 0 0"><joint name="b" type="hinge" axis="0 1 .3"/>
<inertial pos=".02 .06 -.1" mass="1.2" diaginertia=".006 .005 .004"/>
<body name="grip" pos="0 0 -.2"><geom type="box" size=".02 .03 .04" density="2000"/></body>
</body></body></body></worldbody></mujoco>
"""
DRY, VISCOUS, ROTORS, OFFSETS = (9.0, 0.8, 0.2), (12.0, 0.3, 0.1), (2.0, 0.1, 0.02), (0.0, 0.0, 0.1)


def heavier(text: str, share: float = 0.06) -> mujoco.MjModel:
    """The machine of an MJCF text: bodies lighter and heavier than the file says, with rotors."""
    model, rng = mujoco.MjModel.from_xml_string(text), np.random.default_rng(4)
    wrong = 1 + share * rng.choice([-1.0, 1.0], model.nbody)
    model.body_mass *= wrong
    model.body_inertia *= wrong[:, None]
    model.dof_armature[:] = ROTORS
    return model


def moved(t: Array, seed: int, size: Sequence[float]) -> tuple[Array, Array, Array]:
    """Positions, rates, accelerations (samples, n): sums of four sines on each axis."""
    rng, n = np.random.default_rng(seed), len(size)
    w, phase = 2 * np.pi * rng.uniform(0.2, 1.6, (4, n)), rng.uniform(0, 2 * np.pi, (4, n))
    x = w * t[:, None, None] + phase
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    q, v, a = ((np.array(size) / 3 * wave).sum(axis=1) for wave in waves)
    return q, v, a


def inverse(model: mujoco.MjModel, q: Array, v: Array, a: Array) -> Array:
    """MuJoCo's torques (samples, n)."""
    data, torques = mujoco.MjData(model), np.empty_like(q)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        torques[k] = data.qfrc_inverse
    return torques


def rubbed(v: Array, dry: Sequence[float], viscous: Sequence[float]) -> Array:
    """Friction (samples, n)."""
    rms = np.sqrt((v**2).mean(axis=0))
    return np.array(dry) * np.tanh(v / (SHARP * rms)) + np.array(viscous) * v


def write(
    path: Path, t: Array, q: Array, tau: Array, linear: Sequence[bool], head: str, seed: int
) -> Path:
    """A log as CSV: angles with noise of 1e-6, torques with `NOISE` of their deviation."""
    rng, n = np.random.default_rng(seed), q.shape[1]
    read = q + 1e-6 * rng.standard_normal(q.shape)
    seen = tau + NOISE * tau.std(axis=0) * rng.standard_normal(tau.shape)
    names = [f"{name}[{i + 1}]" for name in ("theta", "tau_meas") for i in range(n)]
    units = ["m" if is_linear else "rad" for is_linear in linear]
    units += ["N" if is_linear else "N m" for is_linear in linear]
    with path.open("w") as file:
        file.write(f"{head}time,{','.join(names)}\ns,{','.join(units)}\n")
        np.savetxt(file, np.column_stack([t, read, seen]), delimiter=",", fmt="%.9g")
    return path


def cart_runs(
    folder: Path, model: mujoco.MjModel, seeds: Sequence[int], head: str = ""
) -> list[Path]:
    """A run of the cart along each of these motions."""
    t, paths = np.arange(round(SECONDS / TS)) * TS, []
    for seed in seeds:
        q, v, a = moved(t, seed, (0.25, 0.7, 0.8))
        tau = inverse(model, q, v, a) + rubbed(v, DRY, VISCOUS) + OFFSETS
        text = f"# trajectory: {seed}\n{head}"
        path = folder / f"cart-{seed}{'-loaded' * bool(head)}.csv"
        paths.append(write(path, t, q, tau, (True, False, False), text, seed))
    return paths
