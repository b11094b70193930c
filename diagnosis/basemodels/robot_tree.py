"""The torques of a robot as an expression: Pinocchio's package makes none, so Newton and Euler are
written out along its tree of joints."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from flexhex.diagnosis.basemodels.robot_file import Robot, pinocchio
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.model.rigid_tree import Body, Joint, torques


def tree_torques(robot: Robot, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, bodies: ca.SX) -> ca.SX:
    """Torques (n,) [N m], or forces [N], in the order of the axes; bodies (10 n,): ten parameters
    of each in Pinocchio's order."""
    axes = {place: k for k, place in enumerate(robot.places)}
    order = sorted(axes)
    picked = [axes[place] for place in order]
    parts = [_body(bodies[10 * k : 10 * k + 10]) for k in picked]
    moved = (value[picked] for value in (theta, thetad, thetadd))
    gravity = ca.SX(robot.model.gravity.linear)
    tau = torques(_joints(robot, order), parts, gravity, *moved)
    return tau[[picked.index(k) for k in range(len(picked))]]


def _joints(robot: Robot, order: Sequence[int]) -> list[Joint]:
    """The joints of these places, which are all that the model has."""
    model, pin = robot.model, pinocchio()
    data, neutral, joints = model.createData(), pin.neutral(model), list[Joint]()
    for place in order:
        at, joint = model.jointPlacements[place], model.joints[place]
        jacobian = pin.computeJointJacobian(model, data, neutral, place)
        column = jacobian.reshape(6, model.nv)[:, joint.idx_v]
        turns = bool(np.any(column[3:]))
        axis, before = column[3:] if turns else column[:3], model.parents[place]
        on = order.index(before) if before else -1
        rotation = ca.SX(ca.DM(at.rotation))
        joints.append(Joint(on, ca.SX(at.translation), rotation, ca.SX(axis), turns))
    return joints


def _body(ten: ca.SX) -> Body:
    m, x, y, z, xx, xy, yy, xz, yz, zz = (ten[k] for k in range(10))
    return Body(m, ca.vertcat(x, y, z), ca.blockcat(inertia_rows([xx, yy, zz, xy, xz, yz])))
