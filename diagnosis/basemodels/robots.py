"""Serial and tree machines of rigid bodies from a URDF or MJCF file, by Pinocchio.

    tau = sum over bodies of Y_k(theta, thetad, thetadd) p_k + J_r thetadd

linear in ten parameters of each body and the rotor inertia J_r of each axis, seen behind its gear,
which is free unless the file or one beside it has it. Friction and damping of the file, and effects
of the TOML beside it, are `stated`: the runs say whether they are as the file has them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known, Motion, Stated
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.basemodels.robot_effects import effects_of
from flexhex.diagnosis.basemodels.robot_file import Robot, pinocchio
from flexhex.diagnosis.basemodels.robot_geometry import Placements, configurations
from flexhex.diagnosis.basemodels.robot_tree import tree_torques
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance

Array = NDArray[np.float64]
TEN = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_yy", "J_xz", "J_yz", "J_zz")
"""Parameters of a body about its joint's frame, in Pinocchio's order."""
UNITS = ("kg", *("kg m",) * 3, *("kg m2",) * 6)


class RobotBase(ColumnBase):
    """Base model of a robot sampled every ts [s]; see `flexhex.diagnosis.basemodels.base.Base`."""

    def __init__(self, file: Path, robot: Robot, tolerance: RobotTolerance, ts: float) -> None:
        self.file, self.robot, self._pin = file, robot, pinocchio(file)
        self._data, n = robot.model.createData(), len(robot.places)
        self.length, self.remarks = _length(robot), robot.remarks
        super().__init__(
            robot.kinds, [*_inertias(robot, tolerance, self.length), *_rotors(robot, tolerance)], ts
        )
        carrier = robot.load.axis if robot.load else n - 1
        self.payload = tuple(range(10 * carrier, 10 * carrier + 10))
        self.rotors = tuple(range(10 * n, 11 * n))
        self.reach = self.length * n
        self._at = [robot.model.joints[place].idx_v for place in robot.places]
        bodies = [10 * (place - 1) + k for place in robot.places for k in range(10)]
        self._pick = (slice(None), *np.ix_(self._at, bodies))
        self._identity = np.eye(n)
        placements = Placements(robot, self._pin, self.length, tolerance)
        self.geometry = placements if placements.known else None
        self.stated = Stated(effects_of(file, robot), tolerance.effects)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Columns (samples, n, 11 n): bodies in the order of the axes, then rotors."""
        return self._columns(self.robot.model, theta, thetad, thetadd)

    @property
    def gravity(self) -> Array:
        """(3,) [m/s2] in the frame of the foot."""
        return np.array(self.robot.model.gravity.linear)

    def weights(self, motion: Motion, p: Array) -> Array:
        """Torques (samples, n, 3) of parameters p for gravity of 1 m/s2 along each axis of the
        foot."""
        model, rest, along = self.robot.model.copy(), np.zeros_like(motion.theta), list[Array]()
        for way in np.eye(3):
            model.gravity.linear = way
            along.append(self._columns(model, motion.theta, rest, rest) @ p)
        return np.stack(along, axis=2)

    def _columns(self, model: Any, theta: Array, thetad: Array, thetadd: Array) -> Array:
        data = self._data
        q, v, a = configurations(self.robot, theta), self._sorted(thetad), self._sorted(thetadd)
        regressors = np.empty((len(theta), model.nv, 10 * (model.njoints - 1)))
        for k in range(len(theta)):
            regressors[k] = self._pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
        return np.dstack([regressors[self._pick], self._identity * thetadd[:, :, None]])

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m, N], by inverse dynamics: four times as fast as by columns."""
        bodies = p[: 10 * self.n].reshape(self.n, 10)
        if not bodies[:, 0].all():
            return super().torque(motion, p)
        model, data, pin = self.robot.model.copy(), self._data, self._pin
        for place, ten in zip(self.robot.places, bodies, strict=True):
            model.inertias[place] = pin.Inertia.FromDynamicParameters(ten)
        model.armature[self._at] = p[10 * self.n :]
        q, v, a = (
            configurations(self.robot, motion.theta),
            self._sorted(motion.thetad),
            self._sorted(motion.thetadd),
        )
        torque = np.empty_like(v)
        for k in range(len(q)):
            torque[k] = pin.rnea(model, data, q[k], v[k], a[k])
        return torque[:, self._at]

    def symbolic(self, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX) -> ca.SX:
        """Torques (n,) as an expression of the motion (n,) and the parameters."""
        bodies, rotors = p[: 10 * self.n], p[10 * self.n :]
        return tree_torques(self.robot, theta, thetad, thetadd, bodies) + rotors * thetadd

    def loaded(self, p: Array, payload: float) -> Array:
        """A point mass at the centre of the tool, or of the last body where none is given."""
        loaded, inertia = p.copy(), self.robot.model.inertias[self.robot.places[-1]]
        point = self._pin.Inertia(1.0, inertia.lever, np.zeros((3, 3))).toDynamicParameters()
        loaded[list(self.payload)] += payload * (self.robot.load.unit if self.robot.load else point)
        return loaded

    @property
    def _size(self) -> tuple[int, int]:
        return self.n, len(self.linear)

    def _sorted(self, values: Array) -> Array:
        """Rates (samples, n) in the order of the model."""
        ordered = np.empty_like(values)
        ordered[:, self._at] = values
        return ordered


def _length(robot: Robot) -> float:
    """The longest way between two joints, or to a centre of mass [m]."""
    model = robot.model
    between = [np.linalg.norm(model.jointPlacements[k].translation) for k in robot.places]
    return float(max(*between, *(np.linalg.norm(model.inertias[k].lever) for k in robot.places)))


def _inertias(robot: Robot, known: RobotTolerance, length: float) -> list[Known]:
    listed = []
    for place, body in zip(robot.places, robot.bodies, strict=True):
        ten = robot.model.inertias[place].toDynamicParameters()
        mass, mc, mean = ten[0], np.linalg.norm(ten[1:4]), ten[[4, 6, 9]].mean()
        off = known.centre * length
        for name, unit, value in zip(TEN, UNITS, ten, strict=True):
            spread = known.mass * mass
            if unit == "kg m":
                spread = np.hypot(known.mass * value, off * mass)
            elif unit == "kg m2":
                spread = np.hypot(known.inertia * np.hypot(value, mean), 2 * off * mc)
            name = f"{body}.{name}"
            listed.append(Known(name, unit, float(value), float(spread), name))
    return listed


def _rotors(robot: Robot, known: RobotTolerance) -> list[Known]:
    model, listed = robot.model, list[Known]()
    axes = zip(robot.joints, robot.places, robot.kinds, strict=True)
    for i, (joint, place, kind) in enumerate(axes, start=1):
        armature = float(model.armature[model.joints[place].idx_v])
        value, spread = robot.more.rotor_of(joint, armature, known.inertia)
        group = f"{kind.inertia}_r"
        unit = kind.unit("kg m2")
        listed.append(Known(f"{group}[{i}]", unit, value, spread, group, i - 1))
    return listed
