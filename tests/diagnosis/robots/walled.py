"""A three-joint arm on a wall in MuJoCo: rotors behind gears, friction, a tool beside its URDF."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TS, SECONDS, N = 2e-3, 12.0, 3
GRAVITY = (-9.81, 0.0, 0.0)
"""The foot's z axis is level: it stands out of the wall [m/s2]."""
GEARS = (101.0, 101.0, 51.0)
INERTIAS = (2.6e-5, 3.1e-5, 2.2e-5)
"""Rotors about their own axes [kg m2]; the file beside says `SAID`."""
SAID = (2.4e-5, 3.3e-5, 2.1e-5)
ROTORS = tuple(J * gear**2 for J, gear in zip(INERTIAS, GEARS, strict=True))
DRY, VISCOUS = (1.5, 2.0, 0.8), (0.8, 1.0, 0.3)
TOOL = '<mass value="{}"/><inertia ixx="0.004" iyy="0.003" izz="0.002" ixy="0" ixz="0" iyz="0"/>'
URDF = """<robot name="walled"><link name="wall"/>
<link name="upper"><inertial><origin xyz="0 0 0.1"/><mass value="4"/>
 <inertia ixx="0.03" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.02 0 0.18"/><mass value="3"/>
 <inertia ixx="0.04" iyy="0.04" izz="0.006" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="fore"><inertial><origin xyz="0 0.03 0.12"/><mass value="1.5"/>
 <inertia ixx="0.015" iyy="0.014" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tool0"/>
<joint name="swivel" type="revolute"><parent link="wall"/><child link="upper"/>
 <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="0" velocity="0"/>
</joint>
<joint name="shoulder" type="revolute"><parent link="upper"/><child link="arm"/>
 <origin xyz="0 0 0.15"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="0" velocity="0"/>
</joint>
<joint name="elbow" type="revolute"><parent link="arm"/><child link="fore"/>
 <origin xyz="0 0 0.35"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="0" velocity="0"/>
</joint>
<joint name="flange" type="fixed"><parent link="fore"/><child link="tool0"/>
 <origin xyz="0 0.01 0.25" rpy="0.2 0 0.4"/></joint></robot>
"""
BESIDE = f"""robot = "arm.urdf"
gravity = {list(GRAVITY)}
[tolerance]
mass = 0.1
inertia = 0.1
[tool]
link = "tool0"
mass = 1.3
centre = [0.01, 0, 0.06]
inertia = [0.004, 0.003, 0.002, 0, 0, 0]
""" + "".join(
    f"[rotor.{joint}]\ninertia = {J}\ngear = {gear}\ntolerance = 0.1\n"
    for joint, J, gear in zip(("swivel", "shoulder", "elbow"), SAID, GEARS, strict=True)
)


def model(wrong: float = 0.0, tool: float = 1.3) -> mujoco.MjModel:
    """The arm itself with a tool of this mass and rotors, masses a share off those of its file."""
    inertial = f'<inertial><origin xyz="0.01 0 0.06"/>{TOOL.format(tool)}</inertial>'
    text = URDF.replace('<link name="tool0"/>', f'<link name="tool0">{inertial}</link>')
    built, rng = mujoco.MjModel.from_xml_string(text), np.random.default_rng(3)
    off = 1 + wrong * rng.choice([-1.0, 1.0], built.nbody)
    built.body_mass *= off
    built.body_inertia *= off[:, None]
    built.opt.gravity[:] = GRAVITY
    built.dof_armature[:] = ROTORS
    return built


def felt(arm: mujoco.MjModel, q: Array, v: Array, a: Array) -> Array:
    """MuJoCo's torques (samples, 3)."""
    data, torques = mujoco.MjData(arm), np.empty_like(q)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(arm, data)
        torques[k] = data.qfrc_inverse
    return torques


def files(folder: Path, beside: str = BESIDE) -> Path:
    """The robot's file and the one beside it, which is returned."""
    (folder / "arm.urdf").write_text(URDF)
    (folder / "arm.toml").write_text(beside)
    return folder / "arm.toml"


def run(folder: Path, seed: int, head: str = "", arm: mujoco.MjModel | None = None) -> Path:
    """A log along sums of sines, noise on angles and torques."""
    rng, t = np.random.default_rng(seed), np.arange(round(SECONDS / TS)) * TS
    w, phase = 2 * np.pi * rng.uniform(0.2, 1.4, (4, N)), rng.uniform(0, 2 * np.pi, (4, N))
    x = w * t[:, None, None] + phase
    q, v, a = (0.3 * wave.sum(axis=1) for wave in (np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)))
    tau = felt(arm or model(0.06), q, v, a)
    tau += np.array(DRY) * np.tanh(v / 0.02) + np.array(VISCOUS) * v
    tau += 0.005 * tau.std(axis=0) * rng.standard_normal(tau.shape)
    q = q + 1e-6 * rng.standard_normal(q.shape)
    names = [f"{name}[{i + 1}]" for name in ("theta", "tau_meas") for i in range(N)]
    path = folder / f"run{seed}.csv"
    with path.open("w") as file:
        file.write(f"# trajectory: {seed}\n{head}time,{','.join(names)}\n")
        file.write(f"s{',rad' * N}{',N m' * N}\n")
        np.savetxt(file, np.column_stack([t, q, tau]), delimiter=",", fmt="%.9g")
    return path
