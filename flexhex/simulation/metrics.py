"""Tracking error and feedback torque as [SH, Table I] reports them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.motion import MotionModel
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmus.common.machine.machine import Machine

Array = NDArray[np.float64]
POSE_EVERY = 20
"""Base steps between two samples at which joint errors are carried to the end-effector."""

PAPER = {
    "feedback": (1325.0, 0.8767, 197.3, 166.2, 137.8, 1439.7, 1816.4, 316.5),
    "fixed": (47.6, 0.0185, 8.5, 10.1, 8.0, 43.0, 53.7, 22.7),
    "adaptive": (31.8, 0.0117, 5.2, 5.4, 4.7, 24.7, 26.0, 13.4),
    "repeatability": (6.5, 0.0016, 0.9, 1.0, 0.9, 4.7, 5.0, 2.7),
}
"""Rows of [SH, Table I], total manipulator, in the order and units of `Figures`."""
PAPER_ACTUATORS = {
    "feedback": (565.0, 0.9608),
    "fixed": (34.6, 0.0131),
    "adaptive": (27.5, 0.0097),
    "repeatability": (6.4, 0.0019),
}
"""[SH, Table I], actuators only: e [urad], tau_fb [N m]."""
COLUMNS = (
    ("e", "µrad"),
    ("τ_FB", "N m"),
    ("Δx", "µm"),
    ("Δy", "µm"),
    ("Δz", "µm"),
    ("Δφ", "µrad"),
    ("Δθ", "µrad"),
    ("Δψ", "µrad"),
)
"""Headings and units of `Figures` for people."""


@dataclass(frozen=True)
class Figures:
    """RMS over all joints and samples: e [urad], tau_fb [N m]; end-effector dx, dy, dz [um],
    dphi, dtheta, dpsi [urad] (rotations about x, y, z), NaN without an end-effector."""

    e: float
    tau_fb: float
    dx: float
    dy: float
    dz: float
    dphi: float
    dtheta: float
    dpsi: float

    def row(self) -> tuple[float, ...]:
        """The figures in the order of the table."""
        return tuple(asdict(self).values())


def rms(values: Array) -> float:
    """Root of the mean square of all entries."""
    return float(np.sqrt(np.mean(np.square(values))))


def figures(machine: Machine, theta: Array, e: Array, tau_fb: Array) -> Figures:
    """Figures of one run from samples at the base rate (samples, n): [rad], [rad], [N m].

    The end-effector's error is J_E(theta) e with the nominal kinematics, [SH, V-B].
    """
    if not machine.has_platform:
        return Figures(rms(e) * 1e6, rms(tau_fb), *[math.nan] * 6)
    pose = end_effector_error(machine, theta[::POSE_EVERY], e[::POSE_EVERY])
    micro = [rms(pose[:, k]) * 1e6 for k in range(6)]
    return Figures(rms(e) * 1e6, rms(tau_fb), *micro)


@lru_cache(maxsize=4)
def _motion_model(machine: Machine) -> MotionModel:
    """The kinematics of a machine; CasADi needs most of a second for them."""
    with SYMBOLIC:
        return MotionModel(machine)


def end_effector_error(machine: Machine, theta: Array, e: Array) -> Array:
    """Error of E (samples, 6): position [m], rotation [rad], both in the world frame."""
    model = _motion_model(machine)
    x = model.close(theta)
    moved, _ = model.rates(x, e, np.zeros_like(e))
    lam, lamd = x[:, -4:], moved[:, -4:]
    # small rotation in world axes: 2 vec(lamd conj(lam))
    turn = 2 * (
        lam[:, :1] * lamd[:, 1:] - lamd[:, :1] * lam[:, 1:] - np.cross(lamd[:, 1:], lam[:, 1:])
    )
    return np.hstack([moved[:, -7:-4], turn])
