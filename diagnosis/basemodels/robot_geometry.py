"""Errors of a robot's geometry: where its joints stand on each other, and where gravity points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Known, Motion
from flexhex.diagnosis.basemodels.robot_file import Robot
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance

Array = NDArray[np.float64]
ERRORS = (("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad"))
"""Errors of a joint's place: along and about its own axes."""


def configurations(robot: Robot, theta: Array) -> Array:
    """Configurations (samples, n_q): angle, or its cosine and sine where a joint has no end."""
    configured = np.zeros((len(theta), robot.model.nq))
    for values, place in zip(theta.T, robot.places, strict=True):
        joint = robot.model.joints[place]
        at = joint.idx_q
        if joint.nq == 1:
            configured[:, at] = values
        else:
            configured[:, at], configured[:, at + 1] = np.cos(values), np.sin(values)
    return configured


@dataclass(frozen=True)
class _Displaced:
    """A model in which each joint but the first stands on six more, at zero, that displace it, as
    all do; joints: numbers of the robot's own; errors: places in v of those that are known."""

    model: Any
    data: Any
    joints: Mapping[int, int]
    errors: list[int]


class Placements:
    """Errors of a robot's geometry; see `flexhex.diagnosis.basemodels.base.Geometry`.

    An error of a joint's place is a displacement of six joints before it that do not move, so its
    column is the derivative of inverse dynamics by their coordinates. At the foot only turns about
    level axes are felt: those of gravity.
    """

    def __init__(self, robot: Robot, pin: Any, length: float, tolerance: RobotTolerance) -> None:
        """length: of the robot [m]; tolerance: of places, relative to it, of angles and gravity."""
        self.robot, self._pin = robot, pin
        self.known = _errors(robot, length, tolerance)
        self._displaced = self._built()

    def _built(self) -> _Displaced:
        pin, robot = self._pin, self.robot
        model, joints, errors = pin.Model(), dict[int, int](), list[int]()
        model.gravity = robot.model.gravity
        free, here = pin.JointModelFreeFlyer(), pin.SE3.Identity()
        foot = model.addJoint(0, free, here, "foot")
        gravity = [known.name for known in self.known if known.name.startswith("gravity.")]
        errors += [model.joints[foot].idx_v + 3 + "xyz".index(name[-1]) for name in gravity]
        for place in range(1, robot.model.njoints):
            name, before = robot.model.names[place], robot.model.parents[place]
            at, on = robot.model.jointPlacements[place], joints.get(before, foot)
            if before and len(gravity) < len(self.known):
                on = model.addJoint(on, free, at, f"place of {name}")
                errors += range(model.joints[on].idx_v, model.joints[on].idx_v + 6)
                at = here
            joints[place] = model.addJoint(on, robot.model.joints[place], at, name)
        return _Displaced(model, model.createData(), joints, errors)

    def columns(self, motion: Motion, weights: csr_array, p: Array) -> Array:
        """Derivatives (rows, n, n_e) of the torques at parameters p (n_p,); weights (rows, samples)
        of the smoothing. Zeros in rows that have no sample."""
        rows = np.flatnonzero(weights.sum(axis=1))
        state = [weights[rows] @ v for v in (motion.theta, motion.thetad, motion.thetadd)]
        n = len(self.robot.places)
        derivatives = np.zeros((weights.shape[0], n, len(self.known)))
        masses = p[: 10 * n : 10]
        if (masses > 0).all():
            derivatives[rows] = self._derivatives(state, p)
        else:
            # Pinocchio adds up bodies by their centres, and those of no mass have none; the
            # derivatives are linear in the bodies: as of heavier ones, less those of what was added
            more = np.zeros_like(p)
            more[: 10 * n : 10] = 1.0 + np.maximum(-masses, 0.0)
            derivatives[rows] = self._derivatives(state, p + more) - self._derivatives(state, more)
        return derivatives

    def _derivatives(self, state: Sequence[Array], p: Array) -> Array:
        """The same (samples, n, n_e) of angles, rates and accelerations (samples, n)."""
        robot, pin, (model, data) = self.robot, self._pin, self._model(p)
        own = [model.joints[self._displaced.joints[place]] for place in robot.places]
        at, count = [joint.idx_v for joint in own], len(state[0])
        q = np.tile(pin.neutral(model), (count, 1))
        places = [slice(joint.idx_q, joint.idx_q + joint.nq) for joint in own]
        configuration = configurations(robot, state[0])
        for place, part in zip(robot.places, places, strict=True):
            joint = robot.model.joints[place]
            q[:, part] = configuration[:, joint.idx_q : joint.idx_q + joint.nq]
        v, a = np.zeros((2, count, model.nv))
        v[:, at], a[:, at] = state[1], state[2]
        derivatives = np.zeros((count, len(own), len(self.known)))
        pick = np.ix_(at, self._displaced.errors)
        for k in range(count):
            derivatives[k] = pin.computeRNEADerivatives(model, data, q[k], v[k], a[k])[0][pick]
        return derivatives

    def _model(self, p: Array) -> tuple[Any, Any]:
        """The displaced model with the bodies of parameters p."""
        pin, shown = self._pin, self._displaced
        for k, place in enumerate(self.robot.places):
            ten = p[10 * k : 10 * k + 10]
            shown.model.inertias[shown.joints[place]] = pin.Inertia.FromDynamicParameters(ten)
        return shown.model, shown.data


def _errors(robot: Robot, length: float, tolerance: RobotTolerance) -> tuple[Known, ...]:
    """Gravity's direction, then the place of each joint that stands on another one, in the order
    of the model."""
    model = robot.model
    g = model.gravity.linear
    listed = [
        Known(f"gravity.{axis}", "rad", 0.0, tolerance.gravity, f"gravity.{axis}")
        for axis, moved in zip("xyz", np.cross(g, np.eye(3)), strict=True)
        if moved.any() and tolerance.gravity
    ]
    bodies = dict(zip(robot.places, robot.bodies, strict=True))
    for place in range(1, model.njoints):
        if model.parents[place] and tolerance.geometry:
            for error, unit in ERRORS:
                name = f"{bodies[place]}.{error}"
                size = length if unit == "m" else 1.0
                listed.append(Known(name, unit, 0.0, tolerance.geometry * size, name))
    return tuple(listed)
