"""Kinematics derived anew: constraints from rotation matrices, closure by Newton's method.

All functions take any leading axes and complex numbers, so that `calculus` can
differentiate through them, closure included. x (37,) = theta (6), lam_Q1 (4) ... lam_Q6 (4),
x_E (3), lam_E (4); quaternions are scalar first, body to world.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.calculus import Array, taylor
from tests.oracles.machine import Machine


def rotation(lam: Array) -> Array:
    """|lam|^2 times the rotation matrix (..., 3, 3) of the quaternion lam (..., 4).

    Written from the vector form l0^2 r - (v.v) r + 2 v (v.r) + 2 l0 v x r.
    """
    l0, v = lam[..., 0], lam[..., 1:]
    scale = l0 * l0 - np.sum(v * v, axis=-1)
    diagonal = scale[..., None, None] * np.eye(3)
    dyad = v[..., :, None] * v[..., None, :]
    return np.asarray(diagonal + 2 * dyad + 2 * l0[..., None, None] * cross(v))


def cross(v: Array) -> Array:
    """Matrix (..., 3, 3) of the cross product with v (..., 3)."""
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    rows = [np.stack(row, axis=-1) for row in ((o, -z, y), (z, o, -x), (-y, x, o))]
    return np.stack(rows, axis=-2)


def rotation_rate(lam: Array, lamd: Array) -> Array:
    """Derivative (..., 3, 3) of `rotation` along lamd: its bilinear form, by polarisation."""
    return np.asarray(rotation(lam + lamd) - rotation(lam) - rotation(lamd))


def quaternion(R: Array) -> Array:
    """Unit quaternion (..., 4) of a real rotation matrix (..., 3, 3); its sign is arbitrary."""
    return np.asarray(Rotation.from_matrix(R).as_quat(scalar_first=True))


def multiply(a: Array, b: Array) -> Array:
    """Quaternion product a b (..., 4)."""
    a0, av, b0, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    scalar = a0 * b0 - np.sum(av * bv, axis=-1, keepdims=True)
    return np.concatenate([scalar, a0 * bv + b0 * av + np.cross(av, bv)], axis=-1)


def conjugate(a: Array) -> Array:
    """Conjugate of a quaternion (..., 4), also where its entries are complex numbers."""
    return np.asarray(a * np.array([1.0, -1.0, -1.0, -1.0]))


def upper_rotation(machine: Machine, theta: Array) -> Array:
    """R_B (..., 6, 3, 3) of the upper arms: Rodrigues about `axis` from the neutral frame."""
    K = cross(machine.axis)
    s, c = np.sin(theta)[..., None, None], np.cos(theta)[..., None, None]
    return np.asarray((np.eye(3) + s * K + (1 - c) * (K @ K)) @ machine.R_B0)


def split(x: Array) -> tuple[Array, Array, Array, Array]:
    """theta (..., 6), lam_Q (..., 6, 4), x_E (..., 3), lam_E (..., 4)."""
    return x[..., :6], x[..., 6:30].reshape(*x.shape[:-1], 6, 4), x[..., 30:33], x[..., 33:]


def neutral(machine: Machine) -> Array:
    """x (37,) of the neutral pose."""
    lam_Q = quaternion(machine.R_Q0).ravel()
    return np.concatenate([np.zeros(6), lam_Q, machine.x_E0, [1.0, 0.0, 0.0, 0.0]])


def _antisymmetric(A: Array) -> Array:
    """Half the antisymmetric part of A (..., 3, 3) as a vector (..., 3): sin(angle) axis."""
    parts = (A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1])
    return np.stack(parts, axis=-1) / 2


def deformations(machine: Machine, x: Array) -> tuple[Array, Array]:
    """Twist, bending y, bending z of the universal and of the spherical joints (..., 6, 3).

    Half the antisymmetric part of the relative rotation, which is that of the lower arm
    against the frame that it had at neutral, carried along by the upper arm (universal) or
    by the end-effector (spherical).  [SH, Eq. (5a), (18)], Schwab and Meijaard.
    """
    theta, lam_Q, _, lam_E = split(x)
    R_Q = rotation(lam_Q)
    C = np.swapaxes(machine.R_B0, -1, -2) @ machine.R_Q0
    carried_B = upper_rotation(machine, theta) @ C
    carried_E = rotation(lam_E)[..., None, :, :] @ machine.R_Q0
    universal = _antisymmetric(np.swapaxes(carried_B, -1, -2) @ R_Q)
    return universal, _antisymmetric(np.swapaxes(carried_E, -1, -2) @ R_Q)


def constraints(machine: Machine, x: Array) -> Array:
    """D (..., 31): per arm twist, |lam_Q|^2 - 1, gap at P (3); then |lam_E|^2 - 1.

    [SH, Eq. (5), (6)]
    """
    theta, lam_Q, x_E, lam_E = split(x)
    universal, _ = deformations(machine, x)
    x_Q = machine.x_B + machine.L * upper_rotation(machine, theta)[..., :, 0]
    lower = x_Q + machine.l * rotation(lam_Q)[..., :, 0]
    platform = x_E[..., None, :] + np.einsum("...jk,ik->...ij", rotation(lam_E), machine.r_EP)
    norm = np.sum(lam_Q * lam_Q, axis=-1, keepdims=True) - 1
    arms = np.concatenate([universal[..., :1], norm, platform - lower], axis=-1)
    last = np.sum(lam_E * lam_E, axis=-1, keepdims=True) - 1
    return np.concatenate([arms.reshape(*x.shape[:-1], 30), last], axis=-1)


def constraint_jacobian(machine: Machine, x: Array) -> Array:
    """D_x (..., 31, 37), exact: D is of second degree in every dependent coordinate, where
    the central difference has no error at any step, and of first degree in (cos theta,
    sin theta), where half the difference over +-pi/2 has none.
    """
    steps = np.diag(np.concatenate([np.full(6, np.pi / 2), np.ones(31)]))
    width = np.concatenate([np.full(6, 2.0), np.full(31, 2.0)])
    ahead = constraints(machine, x[..., None, :] + steps)
    behind = constraints(machine, x[..., None, :] - steps)
    return np.swapaxes((ahead - behind) / width[:, None], -1, -2)


def close(machine: Machine, theta: Array) -> Array:
    """x (..., 37) with D = 0 for given theta (..., 6), by Newton from the neutral pose.

    Raises ArithmeticError where 20 iterations do not bring the step below 1e-13.
    """
    start = np.broadcast_to(neutral(machine)[6:], (*theta.shape[:-1], 31))
    x = np.concatenate([theta, start], axis=-1).astype(theta.dtype)
    for _ in range(20):
        D, D_d = constraints(machine, x), constraint_jacobian(machine, x)[..., 6:]
        step = np.linalg.solve(D_d, D[..., None])[..., 0]
        x = np.concatenate([theta, x[..., 6:] - step], axis=-1)
        # Newton is quadratic: after a step this small only rounding is left
        if np.max(np.abs(step)) < 1e-13:
            return x
    raise ArithmeticError(f"closure did not converge, last step {np.max(np.abs(step)):.3g}")


def circle(thetad: Array, thetadd: Array) -> tuple[float, int]:
    """Radius [s] and number of points for `taylor` along a path that starts with these rates.

    The angles move by up to 0.28 rad: far enough for a second derivative of 12 digits, near
    enough for the closure to stay analytic (halving or doubling the points changes nothing).
    """
    size = np.max(np.abs(thetad)) + np.sqrt(np.max(np.abs(thetadd))) + 1e-3
    return 0.25 / float(size), 32


def motion(
    machine: Machine, theta: Array, thetad: Array, thetadd: Array
) -> tuple[Array, Array, Array]:
    """x, xd, xdd (37,): Taylor coefficients of the closure along a path of theta.

    No Jacobian of the constraints enters the result, so it checks [SH, Eq. (15) to (17)].
    """

    def path(s: Array) -> Array:
        s = s[:, None]
        return close(machine, theta + s * thetad + s * s / 2 * thetadd)

    c = taylor(path, 2, *circle(thetad, thetadd))
    return c[0].real, c[1].real, 2 * c[2].real


def dependent_rates(machine: Machine, x: Array) -> Array:
    """J (..., 37, 6) = dx / dtheta by the implicit function theorem.  [SH, Eq. (14)]"""
    D_x = constraint_jacobian(machine, x)
    dependent = -np.linalg.solve(D_x[..., 6:], D_x[..., :6])
    identity = np.broadcast_to(np.eye(6), (*x.shape[:-1], 6, 6))
    return np.concatenate([identity, dependent], axis=-2)
