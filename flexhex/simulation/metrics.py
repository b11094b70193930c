"""Tracking error and feedback torque as [SH, Table I] reports them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.output.tables import Column
from flexhex.tracking import rms as rms

Array = NDArray[np.float64]
POSE_EVERY = 20
"""Base steps between two samples at which joint errors are carried to the end-effector."""

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
KEYS = ("e", "tau_fb", "dx", "dy", "dz", "dphi", "dtheta", "dpsi")


def figure_columns(digits: int = 1, digits_torque: int = 4) -> tuple[Column, ...]:
    """Columns of a table whose rows are `asdict(Figures)`."""
    return tuple(
        Column(key, heading, unit, f".{digits_torque if key == 'tau_fb' else digits}f")
        for key, (heading, unit) in zip(KEYS, COLUMNS, strict=True)
    )


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


def figures(machine: Machine, theta: Array, e: Array, tau_fb: Array) -> Figures:
    """Figures of one run from samples at the base rate (samples, n): [rad], [rad], [N m].

    The end-effector's error is J_E(theta) e with the nominal kinematics, [SH, V-B].
    """
    if not machine.has_platform:
        return Figures(rms(e) * 1e6, rms(tau_fb), *[math.nan] * 6)
    pose = end_effector_error(machine, theta[::POSE_EVERY], e[::POSE_EVERY])
    micro = [rms(pose[:, k]) * 1e6 for k in range(6)]
    return Figures(rms(e) * 1e6, rms(tau_fb), *micro)


def end_effector_error(machine: Machine, theta: Array, e: Array) -> Array:
    """Error of E (samples, 6): position [m], rotation [rad], both in the world frame."""
    # imported here: it takes SciPy along, a second for whoever wants the names of the figures
    from flexhex.diagnosis.estimation.motion import motion_model

    model = motion_model(machine)
    x = model.close(theta)
    moved, _ = model.rates(x, e, np.zeros_like(e))
    lam, lamd = x[:, -4:], moved[:, -4:]
    # small rotation in world axes: 2 vec(lamd conj(lam))
    turn = 2 * (
        lam[:, :1] * lamd[:, 1:] - lamd[:, :1] * lam[:, 1:] - np.cross(lamd[:, 1:], lam[:, 1:])
    )
    return np.hstack([moved[:, -7:-4], turn])
