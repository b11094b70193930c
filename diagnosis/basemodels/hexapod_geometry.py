"""Errors of a hexapod's geometry, arm by arm, through the closed loops.

Eleven for each arm, all that its rigid parts have: the place (x, y, z) and direction (roll, pitch,
yaw) of the motor with all that it carries, in the axes of the upper arm at neutral, y the motor
axis, so that pitch is an offset of the angle; the lengths L and l; the spherical joint's place
(P_x, P_y, P_z) on the end-effector. A common displacement of all six is another frame of the
end-effector: harmless, since each has a tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Geometry, Known, Motion
from flexhex.diagnosis.basemodels.geometry import Derivatives, pulled
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.bodies import Mechanism
from flexhex.fmus.common.model.dynamics import loads, project
from flexhex.fmus.common.model.geometry import ArmFrame, Frames
from flexhex.fmus.common.model.model import Model
from flexhex.numeric.rows import native

Array = NDArray[np.float64]
ENTRIES = (
    *(("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad")),
    *(("L", "m"), ("l", "m"), ("P_x", "m"), ("P_y", "m"), ("P_z", "m")),
)
"""Errors of an arm and their units."""


def misplacements(machine: Machine) -> tuple[Known, ...]:
    """Errors of all arms, with the tolerance of the machine file."""
    tolerance = machine.tolerance.geometry
    length = max(machine.geometry.L, machine.platform.l)
    return tuple(
        Known(
            f"arm[{i + 1}].{name}",
            unit,
            0.0,
            tolerance * (length if unit == "m" else 1.0),
            f"arm.{name}",
        )
        for i in range(machine.n_arms)
        for name, unit in ENTRIES
    )


def geometry_of(
    machine: Machine,
    state: Callable[[Motion], Sequence[Array]],
    first: int,
    n_p: int,
) -> Geometry:
    """What the errors do to the torques.

    state: coordinates x~, joint rates and accelerations of a motion; first: where the mechanism's
    parameters begin among n_p linear ones.
    """
    errors = misplacements(machine)
    model, e = Model(machine), ca.SX.sym("e", len(errors))
    model.frames = displaced(model.frames, e)
    n = model.n
    x, p = ca.SX.sym("x", model.n_x), ca.SX.sym("p", n_p)
    thetad, thetadd = ca.SX.sym("thetad", n), ca.SX.sym("thetadd", n)
    # one correction: x solves the nominal loops, so its derivative by e is exact
    linkage = model.linkage(ca.vertcat(x[:n], model.linkage(x).newton()))
    xd = linkage.rates(thetad)
    motion = model.motion(xd, linkage.accelerations(xd, thetadd))
    tau = project(linkage, loads(linkage, motion, Mechanism.split(p[first:], n)))
    (derivatives,) = native([pulled("native_geometry", [x, thetad, thetadd], p, e, tau)])
    return Derivatives(errors, state, derivatives)


def displaced(frames: Frames, e: ca.SX) -> Frames:
    """Frames with errors e in the order of `misplacements`; numbers become casadi.SX."""
    per = len(ENTRIES)
    arms = (_moved(arm, e[per * i : per * (i + 1)]) for i, arm in enumerate(frames.arms))
    return replace(frames, arms=tuple(arms))


def _moved(arm: ArmFrame, e: ca.SX) -> ArmFrame:
    B = ca.SX(np.column_stack([arm.u_B, arm.axis, np.cross(arm.u_B, arm.axis)]))
    turn = B @ e[3:6]
    lam = qn.mul(ca.vertcat(1, turn / 2), ca.SX(arm.lam_Q0))
    moved: dict[str, Any] = {
        "x_B": ca.SX(arm.x_B) + B @ e[:3],
        "axis": ca.SX(arm.axis) + ca.cross(turn, ca.SX(arm.axis)),
        "u_B": ca.SX(arm.u_B) + ca.cross(turn, ca.SX(arm.u_B)),
        "lam_Q0": lam,
        "L": arm.L + e[6],
        "l": arm.l + e[7],
        "r_EP": ca.SX(arm.r_EP) + e[8:11],
    }
    return replace(arm, **moved)
