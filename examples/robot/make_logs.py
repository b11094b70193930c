"""The arm as it really is, in MuJoCo: sample logs, and runs with a feedforward of your own.

    python examples/robot/make_logs.py [FOLDER]

It has what its file `arm.urdf` lacks: other masses, rotors, dry and viscous friction, a ripple of
the elbow's torque that comes so many times a turn. Two motions are run twice each, a third one
once, to be held out. Nothing here is of flexhex.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np

FILE = Path(__file__).with_name("arm.urdf")
N, STEP, EVERY, SECONDS = 3, 1e-3, 10, 9.0
"""Axes; step of the simulation [s]; steps between samples; length of a log [s]."""
HEAVIER = {"turret": 0.96, "upper_arm": 1.07, "forearm": 1.05}
"""Masses and inertias beside those of the file."""
ROTOR, DRY, VISCOUS = (0.35, 0.45, 0.12), (0.8, 1.5, 0.5), (0.6, 0.9, 0.3)
"""[kg m2], [N m], [N m s/rad], behind the gears."""
RIPPLE, PER_TURN = 0.25, 18
"""Of the elbow's torque [N m]; periods in a turn of the joint."""
STIFF, DAMPED = np.array([1500.0, 2000.0, 700.0]), 0.03
"""Feedback [N m/rad], and its derivative time [s]."""
ENCODER, TORQUE = 2e-6, (0.05, 0.08, 0.03)
"""Noise of the angles [rad] and of the measured torques [N m]."""
CENTRE, STROKE = np.array([0.0, 0.4, 0.9]), np.array([0.9, 0.55, 0.8])
"""Where the motions are, and how wide [rad]."""
RUNS = {"a1": ("a", 1), "a2": ("a", 2), "b1": ("b", 1), "b2": ("b", 2), "c1": ("c", 1)}
"""File -> motion, pass."""


def motion(t: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles, rates and accelerations (samples, 3): five sines for each axis, drawn by the name."""
    draw = np.random.default_rng(ord(name))
    w, phase = 2 * np.pi * draw.uniform(0.1, 0.8, (5, N)), draw.uniform(0, 2 * np.pi, (5, N))
    x, size = w * t[:, None, None] + phase, STROKE / np.sqrt(5 * w)
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    angles, rates, accelerations = ((size * wave).sum(axis=1) for wave in waves)
    return CENTRE + angles, rates, accelerations


def machine() -> mujoco.MjModel:
    """The arm itself."""
    model = mujoco.MjModel.from_xml_path(str(FILE))
    model.opt.timestep = STEP
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    for name, factor in HEAVIER.items():
        body = model.body(name)
        body.mass[:] *= factor
        body.inertia[:] *= factor
    model.dof_armature[:], model.dof_damping[:] = ROTOR, VISCOUS
    model.dof_frictionloss[:] = DRY
    return model


def follow(
    r: np.ndarray, rd: np.ndarray, feedforward: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Angles and torques (samples, 3) of the arm under feedback and a feedforward [N m].

    r [rad], rd, feedforward (samples, 3): at every step of the simulation. The arm begins on r.
    """
    model = machine()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = r[0], rd[0]
    added = np.broadcast_to(feedforward, r.shape)
    theta, tau = np.empty_like(r), np.empty_like(r)
    for k in range(len(r)):
        theta[k] = data.qpos
        tau[k] = added[k] + STIFF * (r[k] - theta[k] + DAMPED * (rd[k] - data.qvel))
        data.qfrc_applied[:] = tau[k]
        data.qfrc_applied[2] -= RIPPLE * np.sin(PER_TURN * theta[k, 2])
        mujoco.mj_step(model, data)
    return theta, tau


def log(name: str, number: int) -> str:
    """One run as CSV: names, units, samples."""
    t = STEP * np.arange(round(SECONDS / STEP))
    r, rd, _ = motion(t, name)
    noise = np.random.default_rng([ord(name), number])
    theta, tau = (values[::EVERY] for values in follow(r, rd))
    theta = theta + ENCODER * noise.standard_normal(theta.shape)
    tau = tau + TORQUE * noise.standard_normal(tau.shape)
    lines = [f"# trajectory: {name}", f"# pass: {number}"]
    lines += [
        ",".join(["time", *(f"{c}[{i + 1}]" for c in ("theta", "tau_meas") for i in range(N))])
    ]
    lines += ["s,rad,rad,rad,N m,N m,N m"]
    for when, angles, torques in zip(t[::EVERY], theta, tau, strict=True):
        lines.append(
            ",".join([f"{when:.2f}", *(f"{v:.6f}" for v in angles), *(f"{v:.3f}" for v in torques)])
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write all runs beside this file, or into the folder that is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for file, (name, number) in RUNS.items():
        (folder / f"{file}.csv").write_text(log(name, number), encoding="utf-8")


if __name__ == "__main__":
    main()
