"""Torques of rigid bodies in a tree of joints that turn or slide, by Newton and Euler."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class Joint:
    """A joint and where it stands when it is at zero, in the frame of the body before.

    before: number of that body, -1 for the foot; at (3,) [m], rotation (3, 3): its place; axis
    (3,): unit vector in its own frame, about which it turns, or along which it slides.
    """

    before: int
    at: ca.SX
    rotation: ca.SX
    axis: ca.SX
    turns: bool


@dataclass(frozen=True)
class Body:
    """What a joint moves: m [kg], first moments mc (3,) [kg m] and moments of inertia J (3, 3)
    [kg m2] about the joint's origin, in its frame."""

    m: ca.SX
    mc: ca.SX
    J: ca.SX


def torques(
    joints: Sequence[Joint],
    bodies: Sequence[Body],
    gravity: ca.SX,
    theta: ca.SX,
    thetad: ca.SX,
    thetadd: ca.SX,
) -> ca.SX:
    """Torques (n,) [N m], forces [N] of joints that slide. Bodies stand before those they carry.

    Outward: rates and accelerations of each body's origin in its own frame; inward:
        f = m a + (S(wd) + S(w) S(w)) mc
        n = S(mc) a + J wd + S(w) J w        about the body's origin
    A joint that slides moves its body's origin, by 2 S(w) xd + xdd more, and takes f along its axis
    instead of n. Gravity (3,) [m/s2] enters as an acceleration of the foot.  [Featherstone, Rigid
    Body Dynamics, 2008, ch. 5]
    """
    S, zero = ca.skew, ca.SX.zeros(3)
    moving = [(zero, zero, -gravity)]  # of the foot, then of each body
    turned, arms, loads = [], [], []
    for k, (joint, body) in enumerate(zip(joints, bodies, strict=True)):
        w, wd, a = moving[joint.before + 1]
        r, R = joint.at, joint.rotation
        x, xd, xdd = (joint.axis * value[k] for value in (theta, thetad, thetadd))
        if joint.turns:
            R = ca.mtimes(R, about(joint.axis, theta[k]))
        else:
            r = r + ca.mtimes(R, x)
        a = ca.mtimes(R.T, a + ca.cross(wd, r) + ca.cross(w, ca.cross(w, r)))
        w, wd = ca.mtimes(R.T, w), ca.mtimes(R.T, wd)
        if joint.turns:
            w, wd = w + xd, wd + xdd + ca.cross(w, xd)
        else:
            a = a + 2 * ca.cross(w, xd) + xdd
        force = body.m * a + ca.mtimes(S(wd) + ca.mtimes(S(w), S(w)), body.mc)
        moment = ca.cross(body.mc, a) + ca.mtimes(body.J, wd) + ca.cross(w, ca.mtimes(body.J, w))
        moving.append((w, wd, a))
        turned.append(R)
        arms.append(r)
        loads.append((force, moment))
    tau: list[ca.SX] = [ca.SX(0)] * len(joints)
    for k in reversed(range(len(joints))):
        joint, (f, n) = joints[k], loads[k]
        tau[k] = ca.dot(joint.axis, n if joint.turns else f)
        if joint.before >= 0:
            on_f, on_n = loads[joint.before]
            f = ca.mtimes(turned[k], f)
            n = ca.mtimes(turned[k], n) + ca.cross(arms[k], f)
            loads[joint.before] = on_f + f, on_n + n
    return ca.vertcat(*tau)


def about(axis: ca.SX, angle: ca.SX) -> ca.SX:
    """Rotation (3, 3) about a unit vector (3,)."""
    along = ca.mtimes(axis, axis.T)
    return along + ca.cos(angle) * (ca.SX.eye(3) - along) + ca.sin(angle) * ca.skew(axis)
