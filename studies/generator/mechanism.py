"""The hexapod's inverse dynamics in NumPy for whole trajectories at once, by virtual power.

Written for the generator of measured runs: rods as two-point bodies, closure of the platform
alone (six distances, Newton), lower arms by the minimal rotation from where the upper arm
carries them, since the universal joint forbids twist [SH, Eq. (5a)]. Vectors come first:
(3, 6, ...) for arms, (3, ...) for the platform, joints (6, ...); the trailing axes are samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.generator.masses import Linear
from studies.generator.vectors import (
    back,
    cross,
    dot,
    matmul,
    minimal,
    multiplied,
    rotation,
    times,
    transposed_matmul,
)
from tests.oracles.calculus import Array
from tests.oracles.machine import Machine

BLOCK = 2000
"""Samples worked on at a time: the arrays of a block stay in the processor's cache."""


@dataclass(frozen=True)
class Pose:
    """What depends on the angles: u, w of the upper arms and rod n (3, 6, ...); carried frames
    B (3, 3, 6, ...), lower arms R_Q (3, 3, 6, ...), R_E (3, 3, ...), rho = R_E r_EP (3, 6, ...);
    A (6, 6, ...) rows [n, rho x n] with its inverse; x_E (3, ...), lam_E (4, ...)."""

    u: Array
    w: Array
    n: Array
    B: Array
    R_Q: Array
    R_E: Array
    rho: Array
    inverse: Array
    x_E: Array
    lam_E: Array


class Mechanism:
    """Geometry of a machine, gravity [m/s2]; the torque of any `Linear` in it."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.g = machine, machine.g
        self.R_Q0 = np.moveaxis(machine.R_Q0, 0, -1)  # (3, 3, 6)
        self.R_B0 = np.moveaxis(machine.R_B0, 0, -1)

    def _arms(self, constant: Array, like: Array) -> Array:
        """A constant of the arms (..., 6) with as many trailing axes as the angles have."""
        return constant.reshape(*constant.shape, *[1] * (like.ndim - 1))

    def _turned(self, v: Array, theta: Array) -> Array:
        """Vectors v (3, 6) turned about the motor axes by theta (6, ...)."""
        axis = self.machine.axis.T
        c, s = np.cos(theta), np.sin(theta)
        along = axis * np.sum(axis * v, axis=0)
        flat, side = self._arms(v - along, theta), self._arms(cross(axis, v), theta)
        return np.asarray(c * flat + s * side + self._arms(along, theta))

    def close(self, theta: Array, start: tuple[Array, Array] | None = None) -> tuple[Array, Array]:
        """Platform x_E (3, ...) and lam_E (4, ...) for theta (6, ...), by Newton's method.

        `start` is a pose near by. ArithmeticError where 30 iterations leave a step over 1e-12.
        """
        m, shape = self.machine, theta.shape[1:]
        if start is None:
            ones = np.ones(shape)
            start = np.multiply.outer(m.x_E0, ones), np.multiply.outer(np.eye(4)[0], ones)
        x, lam = (np.array(part) for part in start)
        elbow = self._arms(m.x_B.T, theta) + m.L * self._turned(m.u_B.T, theta)
        r = self._arms(m.r_EP.T, theta)
        for _ in range(30):
            rho = times(rotation(lam)[:, :, None], r)
            rod = x[:, None] + rho - elbow
            gap = (dot(rod, rod) - m.l**2) / 2
            A = np.moveaxis(np.concatenate([rod, cross(rho, rod)]), (1, 0), (-2, -1))
            step = np.linalg.solve(A, np.moveaxis(gap, 0, -1)[..., None])[..., 0]
            step = np.moveaxis(step, -1, 0)
            x = x - step[:3]
            lam = multiplied(np.concatenate([np.ones((1, *shape)), -step[3:] / 2]), lam)
            lam = lam / np.sqrt(np.sum(lam * lam, axis=0))
            if np.max(np.abs(step), initial=0.0) < 1e-12:
                return x, lam
        raise ArithmeticError(f"closure: last step {np.max(np.abs(step)):.3g}, out of reach")

    def pose(self, theta: Array, start: tuple[Array, Array] | None = None) -> Pose:
        """Everything that depends on theta (6, ...) alone."""
        m = self.machine
        x, lam = self.close(theta, start)
        R_E = rotation(lam)
        u = self._turned(m.u_B.T, theta)
        w = self._turned(np.cross(m.axis, m.u_B).T, theta)
        rho = times(R_E[:, :, None], self._arms(m.r_EP.T, theta))
        rod = x[:, None] + rho - self._arms(m.x_B.T, theta) - m.L * u
        n = rod / m.l
        B = np.stack([self._turned(self.R_Q0[:, k], theta) for k in range(3)], axis=1)
        A = np.moveaxis(np.concatenate([n, cross(rho, n)]), (1, 0), (-2, -1))
        inverse = np.moveaxis(np.linalg.inv(A), (-2, -1), (0, 1))
        R_Q = matmul(B, minimal(back(B, n)))
        return Pose(u, w, n, B, R_Q, R_E, rho, inverse, x, lam)

    def torque(
        self, at: Pose, v: Array, a: Array, p: Linear, gravity: Array | None = None
    ) -> Array:
        """Joint torque (6, ...) [N m] for rates v and accelerations a (6, ...).  [SH, Eq. (21)]"""
        m, n, u, w = self.machine, at.n, at.u, at.w
        g = (self.g if gravity is None else gravity).reshape(3, *[1] * (v.ndim - 1))
        axis = self._arms(m.axis.T, v)
        v_Q, a_Q = m.L * w * v, m.L * (w * a - u * v * v)
        twist = times(at.inverse, dot(n, v_Q))
        v_E, om = twist[:3], twist[3:]
        turn = cross(om[:, None], at.rho)
        nd = (v_E[:, None] + turn - v_Q) / m.l
        rest = cross(om[:, None], turn)
        acc = times(at.inverse, dot(n, a_Q - rest) - m.l * dot(nd, nd))
        a_E, al = acc[:3], acc[3:]
        ndd = (a_E[:, None] + cross(al[:, None], at.rho) + rest - a_Q) / m.l
        # spin about the rod: the relative rate is at right angles to e + n (no twist)
        e = at.B[:, 0]
        ed, om_B, al_B, sweep = cross(axis * v, e), axis * v, axis * a, cross(n, nd)
        c, sum_ = 1 + dot(n, e), e + n
        s = (dot(om_B, sum_) - dot(sweep, e)) / c
        cd = dot(nd, e) + dot(n, ed)
        rate = dot(al_B, sum_) + dot(om_B, ed + nd) - dot(cross(n, ndd), e) - dot(sweep, ed)
        om_Q = sweep + s * n
        al_Q = cross(n, ndd) + (rate - s * cd) / c * n + s * nd
        f, M = _load(p.lower, at.R_Q, om_Q, al_Q, a_Q - g[:, None])
        F, N = _load(p.platform, at.R_E, om, al, a_E - g)
        flex_Q, flex_E, flex_B = self._flexures(at, p)
        M = M + flex_Q
        # power of M on the lower arm's turning, told by its two ends
        G = (cross(M, n) - dot(M, n) / c * cross(e, n)) / m.l
        own = dot(M, n) / c * dot(axis, sum_) + m.L * dot(w, f - G) + dot(axis, flex_B)
        F = F + np.sum(G, axis=1)
        N = N + np.sum(cross(at.rho, G) + flex_E, axis=1)
        wrench = np.concatenate([F, N])
        shared = m.L * dot(w, n) * back(at.inverse, wrench)
        return np.asarray(own + shared + self._upper(at, p, a, g))

    def _upper(self, at: Pose, p: Linear, a: Array, g: Array) -> Array:
        """Upper arms and rotors: J a less the moment of their weight."""
        axis = self._arms(self.machine.axis.T, a)
        z = cross(at.u, axis)  # third axis of B
        x_, z_ = p.upper
        lever = cross(axis, x_ * at.u + z_ * z)
        axial = p.axial.reshape(*p.axial.shape, *[1] * (a.ndim - p.axial.ndim))
        return np.asarray(axial * a - dot(lever, np.broadcast_to(g[:, None], lever.shape)))

    def _flexures(self, at: Pose, p: Linear) -> tuple[Array, Array, Array]:
        """Moments that hold the flexures, on lower arms, platform and upper arms (3, 6, ...)."""
        S = transposed_matmul(at.B, at.R_Q)
        universal = times(at.B, _moment(S, np.stack([0 * p.k_u[0], *p.k_u])))
        R0 = self.R_Q0.reshape(3, 3, 6, *[1] * (at.n.ndim - 2))
        carried = matmul(at.R_E[:, :, None], R0)
        S = transposed_matmul(carried, at.R_Q)
        spherical = times(carried, _moment(S, p.k_s[[0, 1, 1]]))
        return universal + spherical, -spherical, -universal

    def inverse(
        self, q: Array, v: Array, a: Array, p: Linear, gravity: Array | None = None
    ) -> Array:
        """Torque (6, samples) along a trajectory q, v, a (6, samples), block by block."""
        solutions, last = [], None
        for k in range(0, q.shape[1], BLOCK):
            part = slice(k, k + BLOCK)
            at = self.pose(q[:, part], self._guess(q[:, part], last))
            last = at.x_E[:, -1], at.lam_E[:, -1]
            solutions.append(self.torque(at, v[:, part], a[:, part], p, gravity))
        return np.concatenate(solutions, axis=1)

    def _guess(self, q: Array, last: tuple[Array, Array] | None) -> tuple[Array, Array]:
        """Platform poses near those of q: solved at every 16th sample, lines in between."""
        knots = np.unique(np.append(np.arange(0, q.shape[1], 16), q.shape[1] - 1))
        x, lam = self.close(q[:, knots])
        every = np.arange(q.shape[1])
        return tuple(np.array([np.interp(every, knots, row) for row in part]) for part in (x, lam))  # type: ignore[return-value]


def _moment(S: Array, k: Array) -> Array:
    """Gradient of 1/2 k eps^2 over rotations, eps half the antisymmetric part of S."""
    eps = np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]]) / 2
    force = np.stack([k[0] * eps[0], k[1] * eps[1], k[2] * eps[2]])
    return np.asarray(((S[0, 0] + S[1, 1] + S[2, 2]) * force - back(S, force)) / 2)


def _load(body: Array, R: Array, om: Array, al: Array, a: Array) -> tuple[Array, Array]:
    """Force and moment about its origin that move a body; a is less gravity."""
    m, mc, (xx, yy, zz, xy, xz, yz) = body[0], body[1:4], body[4:]

    def inertia(w: Array) -> Array:
        x, y, z = w
        rows = (xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z)
        return np.stack(rows)

    c, spin, gain = times(R, mc), back(R, om), back(R, al)
    moment = times(R, inertia(gain) + cross(spin, inertia(spin)))
    return m * a + cross(al, c) + cross(om, cross(om, c)), moment + cross(c, a)
