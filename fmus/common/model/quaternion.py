"""Quaternions (Euler parameters) lam = (l0, l1, l2, l3), scalar first, body to world.

R(lam) v is the homogeneous form lam (0, v) conj(lam): |lam|^2 times a rotation. It is
quadratic in lam, so the constraints are polynomials and Newton steps stay exact while
|lam| = 1 is only a constraint. All functions take and return casadi.SX columns.
"""

from __future__ import annotations

import math

import casadi as ca

TERMS = 14
"""Of the series in the square of an angle: exact to rounding up to a whole turn."""


def conj(lam: ca.SX) -> ca.SX:
    """Conjugate (4,)."""
    return ca.vertcat(lam[0], -lam[1], -lam[2], -lam[3])


def mul(p: ca.SX, q: ca.SX) -> ca.SX:
    """Quaternion product p q (4,)."""
    p0, pv, q0, qv = p[0], p[1:4], q[0], q[1:4]
    return ca.vertcat(p0 * q0 - ca.dot(pv, qv), p0 * qv + q0 * pv + ca.cross(pv, qv))


def pure(v: ca.SX) -> ca.SX:
    """Quaternion (0, v) of a vector (3,)."""
    return ca.vertcat(0, v)


def rotation(lam: ca.SX) -> ca.SX:
    """R(lam) (3, 3): |lam|^2 times the rotation matrix."""
    w, x, y, z = lam[0], lam[1], lam[2], lam[3]
    return ca.vertcat(
        ca.horzcat(w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        ca.horzcat(2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        ca.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )


def body_rate(lam: ca.SX, lamd: ca.SX) -> ca.SX:
    """omega (3,) [rad/s] in body axes, 2 vec(conj(lam) lamd); likewise alpha from lamdd."""
    return 2 * mul(conj(lam), lamd)[1:4]


def about(axis: ca.SX, angle: ca.SX) -> ca.SX:
    """Quaternion (4,) of a rotation by `angle` [rad] about a unit vector (3,)."""
    return ca.vertcat(ca.cos(angle / 2), ca.sin(angle / 2) * axis)


def rotation_vector(lam: ca.SX) -> ca.SX:
    """Rotation vector (3,) [rad] of a unit quaternion, below half a turn."""
    norm = ca.sqrt(ca.dot(lam[1:4], lam[1:4]) + 1e-30)
    return 2 * ca.atan2(norm, lam[0]) / norm * lam[1:4]


def of_rotation_vector(phi: ca.SX) -> ca.SX:
    """Unit quaternion (4,) of a rotation vector (3,) [rad], within a turn.

    cos(a / 2) and sin(a / 2) / a as series in a^2 = |phi|^2: smooth at zero, where a is not.
    """
    square = ca.dot(phi, phi) / 4
    powers = [(-square) ** k for k in range(TERMS)]
    cosine = sum(power / math.factorial(2 * k) for k, power in enumerate(powers))
    sine = sum(power / math.factorial(2 * k + 1) for k, power in enumerate(powers))
    return ca.vertcat(cosine, sine / 2 * phi)
