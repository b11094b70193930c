"""Frames of the mechanism at the neutral pose (theta = 0), as plain numbers.

Frame B_i: x along the upper arm, y = motor axis. Frame Q_i: x along the lower arm,
y = motor axis made orthogonal to it. Frame E: parallel to the world. The flexures
are free of stress here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.interface import Causality, Variable
from flexhex.fmus.common.machine.machine import Machine

Array = NDArray[np.float64]
WORST_CONDITION = 100.0
"""Of the platform's Jacobian at neutral; the default machine has 1.8. Beyond it the rods hardly
hold one motion of E, or not at all (parallel rods: infinite)."""


@dataclass(frozen=True)
class ArmFrame:
    """Constants of one arm; vectors (3,) in the world at neutral, quaternions (4,).

    S = conj(lam_E0) lam_Q0: Q seen from E at neutral; a_Q: motor axis in the axes of Q at
    neutral; L, l: upper and lower arm [m].
    """

    x_B: Array
    axis: Array
    u_B: Array
    r_EP: Array
    lam_Q0: Array
    S: Array
    a_Q: Array
    L: float
    l: float  # noqa: E741 - the paper's neighbour of L

    @property
    def rod(self) -> Array:
        """Unit vector (3,) along the lower arm at neutral: x of Q."""
        w, x, y, z = self.lam_Q0
        return np.array([w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)])


@dataclass(frozen=True)
class Frames:
    """All arms and the neutral x~, x0 (37,); without a platform no arms, x0 = theta (6,)."""

    arms: tuple[ArmFrame, ...]
    x0: Array

    @staticmethod
    def of(machine: Machine, where: str = "machine") -> Frames:
        """Frames of a machine; MachineError when an arm does not close at neutral, or when the
        lower arms leave the platform a motion there."""
        if not machine.has_platform:
            return Frames((), np.zeros(machine.n_arms))
        arms = tuple(_arm_frame(machine, i, where) for i in range(machine.n_arms))
        _check_condition(arms, where)
        lams = [arm.lam_Q0 for arm in arms]
        x0 = np.concatenate(
            [np.zeros(len(arms)), *lams, np.array(machine.platform.x_E0), [1.0, 0.0, 0.0, 0.0]]
        )
        return Frames(arms, x0)


AXES = ("x", "y", "z")


class Each(TypedDict):
    """What an array of unlike things says of its elements, for `Variable`."""

    elements: tuple[str, ...]
    units: tuple[str, ...]


def coordinates(machine: Machine, rate: str = "") -> Each:
    """Names and units of the elements of x~; rate: `/s` for xd, `/s2` for xdd."""
    arms, four = range(1, machine.n_arms + 1), range(1, 5)
    listed = [(f"theta[{i}]", "rad") for i in arms]
    if machine.has_platform:
        listed += [(f"arm[{i}].lam_Q[{k}]", "1") for i in arms for k in four]
        listed += [(f"x_E.{axis}", "m") for axis in AXES]
        listed += [(f"lam_E[{k}]", "1") for k in four]
    elements, units = zip(*listed, strict=True)
    return {"elements": elements, "units": tuple(unit + rate for unit in units)}


def coordinate_inputs(machine: Machine, title: str) -> tuple[Variable, ...]:
    """Inputs x, xd, xdd of an FMU; title: what x~ is there."""
    x0 = Frames.of(machine).x0
    at, rate, rate2 = (coordinates(machine, unit) for unit in ("", "/s", "/s2"))
    size = len(x0)
    return (
        Variable("x", "input", "1", title, size, x0, min=-10, max=10, **at),
        Variable("xd", "input", "1/s", "its rates", size, min=-1e4, max=1e4, **rate),
        Variable("xdd", "input", "1/s2", "its accelerations", size, min=-1e7, max=1e7, **rate2),
    )


POSE = ("x", "lam")
"""What a pose of E consists of: its position [m], its quaternion as in x~."""


def pose_variables(machine: Machine, causality: Causality) -> tuple[Variable, ...]:
    """x_E (3,), lam_E (4,), then their rates, then their accelerations; they start at neutral.

    lam_E of any length but zero is the orientation of lam_E / |lam_E|.
    """
    at_rest = {"x": machine.platform.x_E0, "lam": (1.0, 0.0, 0.0, 0.0)}
    units = {"x": "m", "lam": "1"}
    texts = {"x": "position of E", "lam": "quaternion of E, scalar first, body to world"}
    derivatives = (
        ("", "", "", 10.0),
        ("d", "/s", ", its rate", 1e4),
        ("dd", "/s2", ", its acceleration", 1e7),
    )
    return tuple(
        Variable(
            f"{name}{suffix}_E",
            causality,
            units[name] + per,
            texts[name] + text,
            size=len(at_rest[name]),
            start=0.0 if suffix else at_rest[name],
            min=-limit,
            max=limit,
            elements=AXES if name == "x" else (),
        )
        for suffix, per, text, limit in derivatives
        for name in POSE
    )


def platform_condition(arms: Sequence[ArmFrame]) -> float:
    """Condition of the 6 x 6 rows (rod, r_EP x rod / s) that the motion of E meets at neutral.

    rod: unit vector along the lower arm; s: root mean square of |r_EP|, so that lengths and
    angles weigh alike.
    """
    s = math.sqrt(sum(float(arm.r_EP @ arm.r_EP) for arm in arms) / len(arms))
    rows = [np.concatenate([arm.rod, np.cross(arm.r_EP, arm.rod) / (s or 1.0)]) for arm in arms]
    return float(np.linalg.cond(np.array(rows)))


def _check_condition(arms: Sequence[ArmFrame], where: str) -> None:
    condition = platform_condition(arms)
    if not condition <= WORST_CONDITION:
        raise MachineError(
            f"{where}: arms: the neutral pose is singular or nearly so: condition"
            f" {condition:.3g} of the platform's Jacobian, at most {WORST_CONDITION:g}; the lower"
            " arms leave the end-effector a motion (they are parallel, or their lines meet one"
            " axis): correct x_B, r_EP, u_B or x_E0 so that they spread"
        )


def _arm_frame(machine: Machine, i: int, where: str) -> ArmFrame:
    arm, platform = machine.arms[i], machine.platform
    x_B, axis = np.array(arm.x_B), np.array(arm.axis)
    u_B, r_EP = np.array(arm.u_B), np.array(platform.r_EP[i])
    rod = np.array(platform.x_E0) + r_EP - x_B - machine.geometry.L * u_B
    length = float(np.linalg.norm(rod))
    if abs(length - platform.l) > 1e-9:
        raise MachineError(
            f"{where}: arm {i + 1} does not close: at the neutral pose its joints are"
            f" {length:.9g} m apart, geometry.l is {platform.l:.9g} m;"
            f" set l = {length:.12g}, or correct x_E0, r_EP, x_B, u_B or L"
        )
    x_Q = rod / length
    y_Q = axis - (axis @ x_Q) * x_Q
    if np.linalg.norm(y_Q) < 0.1:
        raise MachineError(
            f"{where}: arm {i + 1}: lower arm and motor axis are nearly parallel,"
            " the universal joint is singular; correct axis or the neutral pose"
        )
    y_Q /= np.linalg.norm(y_Q)
    R_Q0 = np.column_stack([x_Q, y_Q, np.cross(x_Q, y_Q)])
    lam_Q0 = _quaternion(R_Q0)
    lengths = machine.geometry.L, platform.l
    return ArmFrame(x_B, axis, u_B, r_EP, lam_Q0, lam_Q0, R_Q0.T @ axis, *lengths)


def _quaternion(R: Array) -> Array:
    """Unit quaternion of a rotation matrix: the dominant eigenvector of Bar-Itzhack's matrix."""
    K = np.empty((4, 4))
    K[0, 0] = np.trace(R)
    K[0, 1:] = K[1:, 0] = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    lam = np.linalg.eigh(K)[1][:, -1]
    refined: Array = lam * (np.sign(lam[0]) if lam[0] != 0 else 1.0)
    return refined / np.linalg.norm(refined)
