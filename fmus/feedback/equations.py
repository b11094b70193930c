"""Feedback C: discrete PID, of SX or arrays, and the fractional delay of the reference."""

from __future__ import annotations

from typing import Any

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine


def lagrange(mu: ca.SX) -> ca.SX:
    """Weights (4,) that interpolate samples at ages 0, 1, 2, 3 at the age mu.

    w_k = product over j != k of (mu - j) / (k - j): cubic, exact at a whole age.
    """
    ages = range(4)
    weights = [ca.SX(1)] * 4
    for k in ages:
        for j in ages:
            if j != k:
                weights[k] *= (mu - j) / (k - j)
    return ca.vertcat(*weights)


def integrated(e_I: Any, e_last: Any, e: Any, Ts: Any) -> Any:
    """Integral of e [rad s], one step on, by Tustin's rule."""
    return e_I + Ts / 2 * (e_last + e)


def differentiated(e_D: Any, e_last: Any, e: Any, t_f: Any, Ts: Any) -> Any:
    """Derivative of e [rad/s] behind a first-order lag t_f, one step on, by Tustin's rule.

    s / (t_f s + 1) with s = 2 / Ts (z - 1) / (z + 1).
    """
    return ((2 * t_f - Ts) * e_D + 2 * (e - e_last)) / (2 * t_f + Ts)


def torque(e: Any, e_I: Any, e_D: Any, kp: Any, t_i: Any, t_d: Any) -> Any:
    """tau_fb = kp (e + e_I / t_i + t_d e_D) [N m]; the PID of [SH, IV-C]."""
    return kp * (e + e_I / t_i + t_d * e_D)


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c; joints side by side.

    feedback_lagrange(mu) -> weights (4,)
    feedback_bumpless(e, t_i) -> e_I: the integral that makes the torque zero at rest
    feedback_follow(e, e_last, e_I, e_D, t_f, Ts) -> e_I_next, e_D_next
    feedback_torque(e, e_I, e_D, kp, t_i, t_d) -> tau_fb
    """
    n = machine.n_arms
    e, e_last, e_I, e_D, kp = (ca.SX.sym(k, n) for k in ("e", "e_last", "e_I", "e_D", "kp"))
    mu, t_i, t_d, t_f, Ts = (ca.SX.sym(k) for k in ("mu", "t_i", "t_d", "t_f", "Ts"))
    return [
        ca.Function("feedback_lagrange", [mu], [lagrange(mu)], ["mu"], ["weights"]),
        ca.Function("feedback_bumpless", [e, t_i], [-t_i * e], ["e", "t_i"], ["e_I"]),
        ca.Function(
            "feedback_follow",
            [e, e_last, e_I, e_D, t_f, Ts],
            [integrated(e_I, e_last, e, Ts), differentiated(e_D, e_last, e, t_f, Ts)],
            ["e", "e_last", "e_I", "e_D", "t_f", "Ts"],
            ["e_I_next", "e_D_next"],
        ),
        ca.Function(
            "feedback_torque",
            [e, e_I, e_D, kp, t_i, t_d],
            [torque(e, e_I, e_D, kp, t_i, t_d)],
            ["e", "e_I", "e_D", "kp", "t_i", "t_d"],
            ["tau_fb"],
        ),
    ]
