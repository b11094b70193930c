"""Serial and tree machines of rigid bodies from a URDF or MJCF file, by Pinocchio.

    tau = sum over bodies of Y_k(theta, thetad, thetadd) p_k + J_r thetadd

linear in ten parameters of each body and the rotor inertia J_r of each axis, seen behind its gear,
which is free. Friction of any kind is left out, whatever the file says: it is for the library.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.base import Known, Motion
from flexhex.diagnosis.columns import ColumnBase
from flexhex.diagnosis.robot_file import Robot, pinocchio
from flexhex.diagnosis.robot_tree import tree_torques
from flexhex.fmus.common.machine.sections import Tolerance

Array = NDArray[np.float64]
TEN = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_yy", "J_xz", "J_yz", "J_zz")
"""Parameters of a body about its joint's frame, in Pinocchio's order."""
UNITS = ("kg", *("kg m",) * 3, *("kg m2",) * 6)
ERRORS = (("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad"))
"""Errors of a joint's place: along and about its own axes."""


class RobotBase(ColumnBase):
    """Base model of a robot sampled every ts [s]; see `flexhex.diagnosis.base.Base`."""

    def __init__(self, file: Path, robot: Robot, tolerance: Tolerance, ts: float) -> None:
        self.robot, self._pin = robot, pinocchio(file)
        self._data, n = robot.model.createData(), len(robot.places)
        self.length = _length(robot)
        super().__init__(
            robot.kinds, [*_inertias(robot, tolerance, self.length), *_rotors(robot)], ts
        )
        self.payload = tuple(range(10 * (n - 1), 10 * n))
        self.rotors = tuple(range(10 * n, 11 * n))
        self.reach = self.length * n
        self._at = [robot.model.joints[place].idx_v for place in robot.places]
        bodies = [10 * (place - 1) + k for place in robot.places for k in range(10)]
        self._pick = np.ix_(self._at, bodies)
        self._identity = np.eye(n)
        if tolerance.geometry:
            self.geometry = Placements(self, tolerance.geometry)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Columns (samples, n, 11 n): bodies in the order of the axes, then rotors."""
        model, data, found = self.robot.model, self._data, np.zeros((len(theta), *self._size))
        q, v, a = self.state(theta), self._sorted(thetad), self._sorted(thetadd)
        ten = 10 * self.n
        for k in range(len(theta)):
            Y = self._pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
            found[k, :, :ten] = Y[self._pick]
        found[:, :, ten:] = self._identity * thetadd[:, :, None]
        return found

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
            self.state(motion.theta),
            self._sorted(motion.thetad),
            self._sorted(motion.thetadd),
        )
        found = np.empty_like(v)
        for k in range(len(q)):
            found[k] = pin.rnea(model, data, q[k], v[k], a[k])
        return found[:, self._at]

    def symbolic(self, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX) -> ca.SX:
        """Torques (n,) as an expression of the motion (n,) and the parameters."""
        bodies, rotors = p[: 10 * self.n], p[10 * self.n :]
        return tree_torques(self.robot, theta, thetad, thetadd, bodies) + rotors * thetadd

    def loaded(self, p: Array, payload: float) -> Array:
        """A point mass at the centre of the last body: where it is nobody says."""
        found, inertia = p.copy(), self.robot.model.inertias[self.robot.places[-1]]
        point = self._pin.Inertia(1.0, inertia.lever, np.zeros((3, 3)))
        found[list(self.payload)] += payload * point.toDynamicParameters()
        return found

    @property
    def _size(self) -> tuple[int, int]:
        return self.n, len(self.linear)

    def _sorted(self, values: Array) -> Array:
        """Rates (samples, n) in the order of the model."""
        found = np.empty_like(values)
        found[:, self._at] = values
        return found

    def state(self, theta: Array) -> Array:
        """Configurations (samples, n_q): angle, or its cosine and sine where a joint has no end."""
        found = np.zeros((len(theta), self.robot.model.nq))
        for values, place in zip(theta.T, self.robot.places, strict=True):
            joint = self.robot.model.joints[place]
            at = joint.idx_q
            if joint.nq == 1:
                found[:, at] = values
            else:
                found[:, at], found[:, at + 1] = np.cos(values), np.sin(values)
        return found


@dataclass(frozen=True)
class _Displaced:
    """A model in which each joint but the first stands on six more, at zero, that displace it, as
    all do; joints: numbers of the robot's own; errors: places in v of those that are known."""

    model: Any
    data: Any
    joints: Mapping[int, int]
    errors: list[int]


class Placements:
    """Errors of a robot's geometry; see `flexhex.diagnosis.base.Geometry`.

    An error of a joint's place is a displacement of six joints before it that do not move, so its
    column is the derivative of inverse dynamics by their coordinates. At the foot only turns about
    level axes are felt: those of gravity.
    """

    def __init__(self, base: RobotBase, spread: float) -> None:
        self.base, self.known = base, _errors(base, spread)
        self._displaced = self._built()

    def _built(self) -> _Displaced:
        pin, robot = self.base._pin, self.base.robot
        model, joints, errors = pin.Model(), dict[int, int](), list[int]()
        model.gravity = robot.model.gravity
        free, here = pin.JointModelFreeFlyer(), pin.SE3.Identity()
        foot = model.addJoint(0, free, here, "foot")
        gravity = [known.name for known in self.known if known.name.startswith("gravity.")]
        errors += [model.joints[foot].idx_v + 3 + "xyz".index(name[-1]) for name in gravity]
        for place in range(1, robot.model.njoints):
            name, before = robot.model.names[place], robot.model.parents[place]
            at, on = robot.model.jointPlacements[place], joints.get(before, foot)
            if before:
                on = model.addJoint(on, free, at, f"place of {name}")
                errors += range(model.joints[on].idx_v, model.joints[on].idx_v + 6)
                at = here
            joints[place] = model.addJoint(on, robot.model.joints[place], at, name)
        return _Displaced(model, model.createData(), joints, errors)

    def columns(self, motion: Motion, weights: csr_array, p: Array) -> Array:
        """Derivatives (rows, n, n_e) of the torques at parameters p (n_p,); weights (rows, samples)
        of the smoothing. Zeros in rows that have no sample."""
        base, pin, (model, data) = self.base, self.base._pin, self._model(p)
        rows = np.flatnonzero(weights.sum(axis=1))
        own = [model.joints[self._displaced.joints[place]] for place in base.robot.places]
        at = [joint.idx_v for joint in own]
        state = [weights[rows] @ v for v in (motion.theta, motion.thetad, motion.thetadd)]
        q = np.tile(pin.neutral(model), (len(rows), 1))
        places = [slice(joint.idx_q, joint.idx_q + joint.nq) for joint in own]
        configuration = base.state(state[0])
        for place, part in zip(base.robot.places, places, strict=True):
            joint = base.robot.model.joints[place]
            q[:, part] = configuration[:, joint.idx_q : joint.idx_q + joint.nq]
        v, a = np.zeros((2, len(rows), model.nv))
        v[:, at], a[:, at] = state[1], state[2]
        found = np.zeros((weights.shape[0], base.n, len(self.known)))
        pick = np.ix_(at, self._displaced.errors)
        for k, row in enumerate(rows):
            found[row] = pin.computeRNEADerivatives(model, data, q[k], v[k], a[k])[0][pick]
        return found

    def _model(self, p: Array) -> tuple[Any, Any]:
        """The displaced model with the bodies of parameters p."""
        pin, shown = self.base._pin, self._displaced
        for k, place in enumerate(self.base.robot.places):
            ten = p[10 * k : 10 * k + 10]
            shown.model.inertias[shown.joints[place]] = pin.Inertia.FromDynamicParameters(ten)
        return shown.model, shown.data


def _errors(base: RobotBase, spread: float) -> tuple[Known, ...]:
    """Gravity's direction, then the place of each joint that stands on another one, in the order
    of the model."""
    model = base.robot.model
    g = model.gravity.linear
    listed = [
        Known(f"gravity.{axis}", "rad", 0.0, spread, f"gravity.{axis}")
        for axis, moved in zip("xyz", np.cross(g, np.eye(3)), strict=True)
        if moved.any()
    ]
    bodies = dict(zip(base.robot.places, base.robot.bodies, strict=True))
    for place in range(1, model.njoints):
        if model.parents[place]:
            for error, unit in ERRORS:
                name = f"{bodies[place]}.{error}"
                size = base.length if unit == "m" else 1.0
                listed.append(Known(name, unit, 0.0, spread * size, name))
    return tuple(listed)


def _length(robot: Robot) -> float:
    """The longest way between two joints, or to a centre of mass [m]."""
    model = robot.model
    between = [np.linalg.norm(model.jointPlacements[k].translation) for k in robot.places]
    return float(max(*between, *(np.linalg.norm(model.inertias[k].lever) for k in robot.places)))


def _inertias(robot: Robot, known: Tolerance, length: float) -> list[Known]:
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


def _rotors(robot: Robot) -> list[Known]:
    return [
        Known(f"{kind.inertia}_r[{i}]", kind.unit("kg m2"), 0.0, np.inf, f"{kind.inertia}_r", i - 1)
        for i, kind in enumerate(robot.kinds, start=1)
    ]
