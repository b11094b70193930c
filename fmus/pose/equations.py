"""Inverse kinematics: a wanted pose of E to the angles, in closed form for each arm.

Arm i reaches P_i = x_E + R_E r_EP from x_B when its upper arm ends at distance l from P_i. With
v = P_i - x_B, u = u(theta) the unit vector along the upper arm and u_p = du/dtheta:

    |v - L u|^2 = l^2   <=>   v . u = c,   c = (|v|^2 + L^2 - l^2) / (2 L)         (closure)

u turns in the plane of u_B and axis x u_B; a, b are the parts of v in it. v . u = a cos + b sin = c
and w = v . u_p = b cos - a sin give w^2 = a^2 + b^2 - c^2: two angles, one for each sign of w. The
sign is that at the neutral pose: it changes only where w = 0, where the rod has no lever on its
motor, so no motion that the motors can drive gets across.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.geometry import ArmFrame, Frames


def reach(arm: ArmFrame, x_E: ca.SX, lam_E: ca.SX) -> ca.SX:
    """v (3,) [m]: from the motor of an arm to P_i; lam_E (4,) of any length but zero."""
    R_E = qn.rotation(lam_E) / ca.dot(lam_E, lam_E)
    return x_E + R_E @ ca.SX(arm.r_EP) - ca.SX(arm.x_B)


def plane(arm: ArmFrame) -> tuple[ca.SX, ca.SX]:
    """u_B and axis x u_B (3,): u = u_B cos(theta) + (axis x u_B) sin(theta)."""
    return ca.SX(arm.u_B), ca.SX(np.cross(arm.axis, arm.u_B))


def assembly(arm: ArmFrame) -> float:
    """Sign of w at the neutral pose, where v = L u_B + l rod and u_p = axis x u_B."""
    return float(np.sign(arm.rod @ np.cross(arm.axis, arm.u_B)))


def angle(arm: ArmFrame, v: ca.SX) -> tuple[ca.SX, ca.SX]:
    """theta [rad] of an arm and its margin [rad]: from the dead point, 0 where v is out of reach.

    The margin is the angle between the upper arm and the line of v in its plane, at most a right
    angle.
    """
    u, side = plane(arm)
    a, b = ca.dot(v, u), ca.dot(v, side)
    c = (ca.dot(v, v) + arm.L**2 - arm.l**2) / (2 * arm.L)
    size = ca.sqrt(ca.fmax(a**2 + b**2 - c**2, 0))
    w = assembly(arm) * size
    return ca.atan2(b * c - a * w, a * c + b * w), ca.atan2(size, ca.fabs(c))


def rates(arm: ArmFrame, theta: ca.SX, v: ca.SX, vd: ca.SX, vdd: ca.SX) -> tuple[ca.SX, ca.SX]:
    """thetad [rad/s], thetadd [rad/s2]: the closure differentiated once and twice.

    With rod = v - L u:  L w thetad = vd . rod
        L w thetadd = vdd . rod + |vd|^2 - 2 L thetad vd . u_p + L thetad^2 v . u
    """
    u0, side = plane(arm)
    u = u0 * ca.cos(theta) + side * ca.sin(theta)
    u_p = side * ca.cos(theta) - u0 * ca.sin(theta)
    rod, lever = v - arm.L * u, arm.L * ca.dot(v, u_p)
    thetad = ca.dot(vd, rod) / lever
    carried = thetad**2 * ca.dot(v, u) - 2 * thetad * ca.dot(vd, u_p)
    return thetad, (ca.dot(vdd, rod) + ca.dot(vd, vd) + arm.L * carried) / lever


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c.

    pose_solve(x_E, lam_E, xd_E, lamd_E, xdd_E, lamdd_E) -> r, rd, rdd, margin (6,): no finite rates
    where a margin is zero, nothing finite where lam_E is
    """
    sizes = {"x_E": 3, "lam_E": 4, "xd_E": 3, "lamd_E": 4, "xdd_E": 3, "lamdd_E": 4}
    s = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
    at, rate = ca.vertcat(s["x_E"], s["lam_E"]), ca.vertcat(s["xd_E"], s["lamd_E"])
    rate2 = ca.vertcat(s["xdd_E"], s["lamdd_E"])
    parts = []
    for arm in Frames.of(machine).arms:
        v = reach(arm, s["x_E"], s["lam_E"])
        vd = ca.jtimes(v, at, rate)
        vdd = ca.jtimes(vd, ca.vertcat(at, rate), ca.vertcat(rate, rate2))
        theta, margin = angle(arm, v)
        parts.append((theta, *rates(arm, theta, v, vd, vdd), margin))
    solved = ca.cse([ca.vertcat(*column) for column in zip(*parts, strict=True)])
    names = ["r", "rd", "rdd", "margin"]
    return [ca.Function("pose_solve", list(s.values()), solved, list(s), names)]
