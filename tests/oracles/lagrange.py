"""Joint torques from energies alone: no angular velocity, no Newton-Euler, no projection.

    tau = d/dt dT/dthetad - dT/dtheta + dV/dtheta + chi

with theta the only coordinates. Kinetic energy comes from the second moments of mass and
the rates of rotation matrices, elastic energy from 1/2 eps^T K eps.
"""

from __future__ import annotations

import numpy as np

from tests.oracles.calculus import Array, gradient, taylor
from tests.oracles.geometry import (
    circle,
    close,
    cross,
    deformations,
    dependent_rates,
    rotation,
    rotation_rate,
    split,
    upper_rotation,
)
from tests.oracles.machine import Body, Machine


def _second_moment(body: Body) -> Array:
    """Integral of r r^T dm (3, 3) [kg m2] about the frame's origin."""
    moment: Array = np.trace(body.J) / 2 * np.eye(3) - body.J
    return moment


def _body_energy(body: Body, v: Array, Rd: Array) -> Array:
    """Kinetic energy (...) [J] of a body whose origin moves at v (..., 3) and R at Rd."""
    spin = np.einsum("...ij,jk,...ik->...", Rd, _second_moment(body), Rd) / 2
    coupling = np.einsum("...i,...ij,j->...", v, Rd, body.c) * body.m
    return np.asarray(spin + coupling + body.m / 2 * np.sum(v * v, axis=-1))


def kinetic_energy(machine: Machine, x: Array, xd: Array) -> Array:
    """T (...) [J] for coordinates x (..., 37) on the constraints and their rates xd."""
    theta, lam_Q, _, lam_E = split(x)
    thetad, lamd_Q, v_E, lamd_E = split(xd)
    Rd_B = thetad[..., None, None] * (cross(machine.axis) @ upper_rotation(machine, theta))
    v_Q = machine.L * Rd_B[..., :, 0]
    upper = _body_energy(machine.upper, np.zeros_like(v_Q), Rd_B)
    rotor = machine.J_rotor / 2 * thetad * thetad
    lower = _body_energy(machine.lower, v_Q, rotation_rate(lam_Q, lamd_Q))
    platform = _body_energy(machine.end_effector, v_E, rotation_rate(lam_E, lamd_E))
    return np.asarray(np.sum(upper + rotor + lower, axis=-1) + platform)


def gravity_energy(machine: Machine, x: Array) -> Array:
    """Potential energy (...) [J] of the weights."""
    theta, lam_Q, x_E, lam_E = split(x)
    R_B = upper_rotation(machine, theta)
    centre_upper = machine.x_B + R_B @ machine.upper.c
    x_Q = machine.x_B + machine.L * R_B[..., :, 0]
    centre_lower = x_Q + rotation(lam_Q) @ machine.lower.c
    centre_platform = x_E + rotation(lam_E) @ machine.end_effector.c
    arms = machine.upper.m * centre_upper + machine.lower.m * centre_lower
    moment = np.sum(arms, axis=-2) + machine.end_effector.m * centre_platform
    return np.asarray(-moment @ machine.g)


def elastic_energy(machine: Machine, x: Array) -> Array:
    """1/2 eps^T K eps (...) [J] of all flexure joints.  [SH, Eq. (18), (19)]"""
    universal, spherical = deformations(machine, x)
    k_twist, k_bending = machine.k_s
    k = np.array([k_twist, k_bending, k_bending])
    squares = np.sum(universal[..., 1:] ** 2 * machine.k_u, axis=-1)
    return np.asarray(np.sum(squares + np.sum(spherical**2 * k, axis=-1), axis=-1) / 2)


def elastic_torque(machine: Machine, theta: Array) -> Array:
    """Torque (6,) [N m] that holds the flexures: the gradient of their energy."""
    return gradient(lambda th: elastic_energy(machine, close(machine, th)), theta)


def gravity_torque(machine: Machine, theta: Array) -> Array:
    """Torque (6,) [N m] that holds the weights."""
    return gradient(lambda th: gravity_energy(machine, close(machine, th)), theta)


def _momentum(machine: Machine, theta: Array, thetad: Array) -> Array:
    """dT / dthetad (..., 6) [N m s], by polarisation of the quadratic form T."""
    x = close(machine, theta)[..., None, :]
    J = dependent_rates(machine, x[..., 0, :])
    unit = np.swapaxes(J, -1, -2)
    xd = np.einsum("...ij,...j->...i", J, thetad)[..., None, :]
    both = kinetic_energy(machine, x, xd + unit)
    return np.asarray(both - kinetic_energy(machine, x, xd) - kinetic_energy(machine, x, unit))


def inertial_torque(machine: Machine, theta: Array, thetad: Array, thetadd: Array) -> Array:
    """Torque (6,) [N m] of inertia without gravity, by Lagrange's equations."""

    def momentum(s: Array) -> Array:
        s = s[:, None]
        return _momentum(machine, theta + s * thetad + s * s / 2 * thetadd, thetad + s * thetadd)

    def energy(th: Array) -> Array:
        x = close(machine, th)
        return kinetic_energy(machine, x, dependent_rates(machine, x) @ thetad)

    rate = taylor(momentum, 1, *circle(thetad, thetadd))[1].real
    return np.asarray(rate - gradient(energy, theta))


def torque(machine: Machine, theta: Array, thetad: Array, thetadd: Array) -> Array:
    """Torque (6,) [N m] of inertia, gravity and flexures; chi is not in it."""
    still = gravity_torque(machine, theta) + elastic_torque(machine, theta)
    return np.asarray(inertial_torque(machine, theta, thetad, thetadd) + still)
