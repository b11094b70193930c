"""Equations of motion (24), linear in their parameters, projected by structure.

The forces of every body are taken about its frame's origin, carried to the joint angle of
its arm and to the platform (virtual work, the explicit projection (8)), and the platform's
wrench is carried to the joints by the transposed loop closure, J^T of [SH, Eq. (13), (14)].
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.bodies import Mechanism
from flexhex.fmus.common.model.constraints import Coordinates, deformations
from flexhex.fmus.common.model.linkage import ArmPose, FreeArms, Linkage, UpperPose


@dataclass(frozen=True)
class FrameMotion:
    """Velocities and accelerations of all frames along (xd, xdd)."""

    xd: Coordinates
    xdd: Coordinates
    g: ca.SX


@dataclass(frozen=True)
class Loads:
    """What a motion asks for: torque at each joint (n,), force on E (3,) in the world and
    moment about E (3,) in its own axes, all dual to theta and the platform's motion."""

    joint: ca.SX
    force: ca.SX
    moment: ca.SX


def body_wrench(par: ca.SX, R: ca.SX, a: ca.SX, w: ca.SX, wd: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Force (3,) in the world and moment (3,) in body axes that a motion asks for.  [SH, Eq. (7)]

        F = R (m a_b + wd x mc + w x (w x mc)),  n = J wd + w x J w + mc x a_b

    par (10,): m, mc, J about the origin; a (3,): acceleration of the origin minus gravity
    [m/s2]; w, wd (3,): angular velocity and acceleration in body axes.
    """
    m, mc = par[0], par[1:4]
    J = ca.blockcat(inertia_rows([par[k] for k in range(4, 10)]))
    a_b = R.T @ a
    force = R @ (m * a_b + ca.cross(wd, mc) + ca.cross(w, ca.cross(w, mc)))
    return force, J @ wd + ca.cross(w, J @ w) + ca.cross(mc, a_b)


def bending_moment(q: ca.SX, k: ca.SX) -> ca.SX:
    """Moment (3,) on the body that turns: sum_k k eps (d eps / d phi).  [SH, Eq. (19), (20)]

    q (4,): relative quaternion; k (3,): stiffness [N m/rad] about x, y, z. phi is a
    rotation of the turning body about its own axes. What is summed is k eps, the flexure's
    torque sigma of (19) with its sign turned.
    """
    qv, q0 = q[1:4], q[0]
    torque = k * deformations(q)
    return -ca.dot(torque, qv) * qv + q0 * (q0 * torque + ca.cross(torque, qv))


def bending_reaction(q: ca.SX, k: ca.SX) -> ca.SX:
    """Moment (3,) on the carrying body in the axes of neutral: sum_k k eps (d eps / d b)."""
    qv, q0 = q[1:4], q[0]
    torque = k * deformations(q)
    return ca.dot(torque, qv) * qv - q0 * (q0 * torque - ca.cross(torque, qv))


def upper_torque(pose: UpperPose, motion: FrameMotion, par: Mechanism, i: int) -> ca.SX:
    """Torque of the upper arm i, J thetadd minus its weight's.  [SH, Eq. (7), (8)]"""
    J, mc_x, mc_z = par.upper[i][0], par.upper[i][1], par.upper[i][2]
    torque: ca.SX = J * motion.xdd.theta[i] - ca.dot(motion.g, mc_x * pose.up + mc_z * pose.u)
    return torque


def arm_loads(pose: ArmPose, motion: FrameMotion, par: Mechanism, i: int) -> Loads:
    """Loads of arm i: upper arm, lower arm and its two joints' flexures."""
    thetad, thetadd = motion.xd.theta[i], motion.xdd.theta[i]
    lamd, lamdd = motion.xd.lam_Q[i], motion.xdd.lam_Q[i]
    joint = upper_torque(pose, motion, par, i)

    a_Q = pose.L * (thetadd * pose.up - thetad**2 * pose.u) - motion.g
    w, wd = qn.body_rate(pose.lam_Q, lamd), qn.body_rate(pose.lam_Q, lamdd)
    force, moment = body_wrench(par.lower[i], pose.R_Q, a_Q, w, wd)
    joint += pose.L * ca.dot(force, pose.up)

    stiffness = par.stiffness[i]
    k_u = ca.vertcat(0, stiffness[0], stiffness[1])
    k_s = ca.vertcat(stiffness[2], stiffness[3], stiffness[3])
    moment += bending_moment(pose.q, k_u) + bending_moment(pose.s, k_s)
    joint += ca.dot(bending_reaction(pose.q, k_u), ca.SX(pose.arm.a_Q))
    on_E = qn.rotation(ca.SX(pose.arm.S)) @ bending_reaction(pose.s, k_s)

    carried, f_P = rod_transpose(pose, moment)
    return Loads(joint + carried, f_P, on_E)


def rod_transpose(pose: ArmPose, moment: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A moment on the lower arm (3,), in its axes, as joint torque and force at P_i (3,).

    The transpose of `ArmPose.solve_rod`: the lower arm turns by what theta and P_i do.
    """
    q, n2 = pose.q, pose.n_Q**2
    den = q[0] ** 2 - q[1] ** 2
    about_y = moment[1] + moment[0] * (q[1] * q[2] + q[0] * q[3]) / den
    about_z = moment[2] - moment[0] * (q[0] * q[2] - q[1] * q[3]) / den
    f_P = (pose.R_Q[:, 1] * about_z - pose.R_Q[:, 2] * about_y) / (pose.l * n2)
    joint = -pose.twist_rate() * moment[0] / den - pose.L * ca.dot(pose.up, f_P)
    return joint, f_P


def loads(linkage: Linkage | FreeArms, motion: FrameMotion, par: Mechanism) -> Loads:
    """All bodies and flexures: M~ xdd + h~ - f~ - g~ before the implicit projection."""
    if isinstance(linkage, FreeArms):
        alone = [upper_torque(pose, motion, par, i) for i, pose in enumerate(linkage.arms)]
        return Loads(ca.vertcat(*alone), ca.SX.zeros(3), ca.SX.zeros(3))
    xt, R_E = linkage.xt, linkage.R_E
    w, wd = qn.body_rate(xt.lam_E, motion.xd.lam_E), qn.body_rate(xt.lam_E, motion.xdd.lam_E)
    force, moment = body_wrench(par.end_effector, R_E, motion.xdd.x_E - motion.g, w, wd)
    joints = []
    for i, pose in enumerate(linkage.arms):
        arm = arm_loads(pose, motion, par, i)
        joints.append(arm.joint)
        force += arm.force
        moment += ca.cross(ca.SX(pose.arm.r_EP), R_E.T @ arm.force) + arm.moment
    return Loads(ca.vertcat(*joints), force, moment)


def project(linkage: Linkage | FreeArms, load: Loads) -> ca.SX:
    """Joint torques J^T (...) (n,).  [SH, Eq. (21)]"""
    if isinstance(linkage, FreeArms):
        return load.joint
    along = linkage.platform.solve_transposed(ca.vertcat(load.force, load.moment))
    beta = ca.vertcat(*(pose.beta for pose in linkage.arms))
    return load.joint + beta * along


def platform_jacobian(linkage: Linkage | FreeArms) -> ca.SX:
    """Motion of E for each joint rate (6, n): velocity in the world, rotation in its axes."""
    if isinstance(linkage, FreeArms):
        return ca.SX(6, linkage.n)
    columns = []
    for i, pose in enumerate(linkage.arms):
        unit = ca.SX.zeros(linkage.n)
        unit[i] = pose.beta
        columns.append(linkage.platform.solve(unit))
    return ca.horzcat(*columns)
