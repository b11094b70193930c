"""Actuator torque chi(theta, z) and the Dahl state of the hysteresis."""

from __future__ import annotations

import casadi as ca


def dahl(z: ca.SX, delta: ca.SX, sigma: ca.SX | float) -> ca.SX:
    """Dahl state after an angle step `delta` [rad], exact for a step of one sign.

        z+ = s + (z - s) exp(-|delta| / sigma),  s = sign(delta)      [SH, Eq. (23)]

    [SH, Eq. (30)] is its Euler step, unstable for |delta| > 2 sigma.
    """
    s = ca.sign(delta)
    return s + (z - s) * ca.exp(-ca.fabs(delta) / sigma)


def dahl_rate(z: ca.SX, thetad: ca.SX, sigma: ca.SX | float) -> ca.SX:
    """z' = (thetad - |thetad| z) / sigma.  [SH, Eq. (23)]"""
    return (thetad - ca.fabs(thetad) * z) / sigma


def cogging_basis(theta: ca.SX, omega: float, n_harmonics: int) -> ca.SX:
    """(cos(omega theta), sin(omega theta), cos(2 omega theta), ...) (2 n_harmonics,).

    Multiples by angle addition: one sine and one cosine for all harmonics.
    """
    cosine, sine = ca.cos(omega * theta), ca.sin(omega * theta)
    c, s, basis = cosine, sine, [cosine, sine]
    for _ in range(n_harmonics - 1):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        basis += [c, s]
    return ca.vertcat(*basis)


def basis(theta: ca.SX, omega: float, n_harmonics: int, z: ca.SX) -> ca.SX:
    """What of chi is nonlinear in the angle: z, then the cogging basis (1 + 2 n_harmonics,)."""
    return ca.vertcat(z, cogging_basis(theta, omega, n_harmonics))


def torque(par: ca.SX, theta: ca.SX, thetad: ca.SX, chi: ca.SX) -> ca.SX:
    """chi_i [N m] of one actuator.  [SH, Eq. (22)]

        chi_i = o + k theta + d thetad + c z + sum_n a_n cos(n omega theta) + b_n sin(...)

    par (4 + 2 n,): o, k, d, c, a_1, b_1, ...; chi (1 + 2 n,): `basis`.
    """
    return par[0] + par[1] * theta + par[2] * thetad + ca.dot(par[3:], chi)
