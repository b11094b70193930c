"""What the page draws of a machine: the hexapod, a tree of joints, bars, or nothing but signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.diagnosis.basemodels.own import OwnBase
from flexhex.diagnosis.basemodels.robot_file import Robot, pinocchio
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.ssp.result import Array
from flexhex.view.meshes import Mesh, meshes_of
from flexhex.view.thin import packed

SHORT = 1e-3
"""Two frames that are no farther apart than this are at one place [m]."""


@dataclass(frozen=True)
class Shape:
    """joints: names of the axes. data: the drawing as JSON, by its `kind`: `hexapod`, `tree`,
    `bars` (whose places come with the runs) or `none`, with a sentence that says why. base: whose
    bars they are. stroke: angle [rad] beyond which no joint goes. said: what is not
    drawn, or nothing."""

    joints: tuple[str, ...]
    data: dict[str, Any]
    base: OwnBase | None = None
    stroke: float = np.inf
    said: str = ""

    @property
    def width(self) -> int:
        """Axes."""
        return len(self.joints)


def of_machine(machine: Machine) -> Shape:
    """Lengths [m] and directions of a hexapod's machine file, by its names.

    UsageError for a machine without a platform.
    """
    if not machine.has_platform or machine.n_arms != 6:
        raise UsageError(f"machine {machine.name!r} is no hexapod: it has no platform on six arms")
    platform = machine.platform
    arms = [
        {"x_B": arm.x_B, "axis": arm.axis, "u_B": arm.u_B, "r_EP": platform.r_EP[i]}
        for i, arm in enumerate(machine.arms)
    ]
    drawn = {
        "kind": "hexapod",
        "name": machine.name,
        "L": machine.geometry.L,
        "l": platform.l,
        "x_E0": platform.x_E0,
        "c_payload": platform.end_effector.c_payload,
        "arms": arms,
    }
    return Shape(_numbered(len(arms)), drawn, stroke=machine.geometry.stroke)


def of_base(base: Base, name: str) -> Shape:
    """What can be drawn of a base model; name: as the command line calls it."""
    if isinstance(base, HexapodBase):
        return of_machine(base.machine)
    if isinstance(base, RobotBase):
        joints = _robot(base.robot)
        meshes, said = meshes_of(base.file, base.robot)
        for axis, mesh in meshes.items():
            if axis >= 0:
                joints[axis]["mesh"] = _mesh(mesh)
        drawn = tree(name, joints) | ({"foot": _mesh(meshes[-1])} if -1 in meshes else {})
        return Shape(base.robot.joints, drawn, said=said)
    if isinstance(base, OwnBase) and base.bars(np.zeros((1, base.n))) is not None:
        return Shape(_numbered(base.n), {"kind": "bars", "name": name}, base)
    if name == "axis":
        text = "Axes by themselves: nothing is known of the machine that they belong to"
    else:
        text = f"{name} has no `bars`, which would say where its parts are"
    drawn = {
        "kind": "none",
        "name": name,
        "text": f"{text}, so there are signals and no picture of it.",
    }
    return Shape(_numbered(base.n), drawn)


def _numbered(n: int) -> tuple[str, ...]:
    return tuple(f"joint {i}" for i in range(1, n + 1))


def tree(name: str, joints: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A tree of rigid bodies, one behind each joint.

    joints: `parent` (-1: the foot), `at` (3,) [m] and `turn` (4,), the place of its frame in that
    of its parent, `axis` (3,), `turns` or it slides, `tip` (3,) [m], where the body ends that has
    no further joint, and `mesh` where its shape is known: `points` and `faces`. The shape of what
    stands still is the `foot` beside them.
    """
    return {"kind": "tree", "name": name, "joints": list(joints)}


def _robot(robot: Robot) -> list[dict[str, Any]]:
    """Joints in the order of the axes, from Pinocchio's frames."""
    model, pin = robot.model, pinocchio()
    data, neutral = model.createData(), pin.neutral(model)
    axes = {place: k for k, place in enumerate(robot.places)}
    shapes = []
    for place, kind in zip(robot.places, robot.kinds, strict=True):
        at, before = model.jointPlacements[place], model.parents[place]
        jacobian = pin.computeJointJacobian(model, data, neutral, place)
        column = jacobian.reshape(6, model.nv)[:, model.joints[place].idx_v]
        axis = column[3:] if kind.turns else column[:3]
        frames = [f.placement.translation for f in model.frames if f.parentJoint == place]
        tip = max(frames, key=np.linalg.norm, default=np.zeros(3))
        if np.linalg.norm(tip) < SHORT:
            tip = 2 * model.inertias[place].lever
        shapes.append(
            _joint(axes.get(before, -1), at.translation, at.rotation, axis, kind.turns, tip)
        )
    return shapes


def _mesh(mesh: Mesh) -> dict[str, str]:
    """Corners of the triangles are whole numbers, which float32 has up to 16 million."""
    return {"points": packed(mesh.points), "faces": packed(mesh.faces.astype(np.float64))}


def _joint(
    parent: int, at: Array, turned: Array, axis: Array, turns: bool, tip: Array
) -> dict[str, Any]:
    return {
        "parent": parent,
        "at": rounded(at),
        "turn": rounded(quaternion(turned)),
        "axis": rounded(axis),
        "turns": turns,
        "tip": rounded(tip),
    }


def quaternion(R: Array) -> Array:
    """Scalar first, body to world, of a rotation (3, 3).

    The eigenvector of the largest eigenvalue of a matrix that is linear in R (Bar-Itzhack).
    """
    x, y, z = (R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
    K = np.array([[np.trace(R), x, y, z], [x, 0, 0, 0], [y, 0, 0, 0], [z, 0, 0, 0]])
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    _, vectors = np.linalg.eigh(K)
    q = vectors[:, -1]
    return np.asarray(q if q[0] >= 0 else -q)


def rounded(values: Array) -> list[float]:
    """Nanometres: what JSON needs not carry further."""
    return [float(round(v, 9)) + 0.0 for v in values]
