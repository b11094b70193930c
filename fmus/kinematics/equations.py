"""Newton-Raphson kinematics N: prediction (28), correction (29), rates (15)-(17), Dahl (30)."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common import actuator
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.linkage import half_angles
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.solve import dot


def predict(d: ca.SX, dd: ca.SX, ddd: ca.SX, dt: ca.SX) -> ca.SX:
    """d (31,) one period on, d + dd dt + ddd dt^2 / 2.  [SH, Eq. (28)]"""
    return d + dd * dt + ddd * (dt**2 / 2)


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c.

    kinematics_predict(d, dd, ddd, dt) -> d_next (31,)
    kinematics_turn(theta) -> half (12,): cosine and sine of the half angles, once a tick
    kinematics_correct(half, d) -> d_next: one Newton correction (29)
    kinematics_rates(half, d, thetad, thetadd) -> xd, xdd (37,), residual = |D| (Euclid)
    kinematics_dahl(z, theta_last, theta) -> z_next (6,)
    kinematics_neutral() -> d (31,)
    """
    model = Model(machine)
    n = model.n
    theta, thetad = ca.SX.sym("theta", n), ca.SX.sym("thetad", n)
    thetadd, d = ca.SX.sym("thetadd", n), ca.SX.sym("d", model.n_x - n)
    dd, ddd, dt = ca.SX.sym("dd", d.numel()), ca.SX.sym("ddd", d.numel()), ca.SX.sym("dt")
    z, theta_last = ca.SX.sym("z", n), ca.SX.sym("theta_last", n)

    half = ca.SX.sym("half", 2, n)
    linkage = model.linkage(ca.vertcat(theta, d), half)
    xd = linkage.rates(thetad)
    xdd = linkage.accelerations(xd, thetadd)
    D = linkage.residual()
    residual = ca.sqrt(dot(D, D))
    z_next = [
        actuator.dahl(z[i], theta[i] - theta_last[i], machine.actuator.sigma) for i in range(n)
    ]
    return [
        ca.Function(
            "kinematics_predict",
            [d, dd, ddd, dt],
            [predict(d, dd, ddd, dt)],
            ["d", "dd", "ddd", "dt"],
            ["d_next"],
        ),
        ca.Function("kinematics_turn", [theta], [ca.vec(half_angles(theta))], ["theta"], ["half"]),
        ca.Function(
            "kinematics_correct",
            [half, d],
            ca.cse([linkage.newton()]),
            ["half", "d"],
            ["d_next"],
        ),
        ca.Function(
            "kinematics_rates",
            [half, d, thetad, thetadd],
            ca.cse([xd, xdd, residual]),
            ["half", "d", "thetad", "thetadd"],
            ["xd", "xdd", "residual"],
        ),
        ca.Function(
            "kinematics_dahl",
            [z, theta_last, theta],
            [ca.vertcat(*z_next)],
            ["z", "theta_last", "theta"],
            ["z_next"],
        ),
        ca.Function("kinematics_neutral", [], [ca.SX(model.frames.x0[n:])], [], ["d"]),
    ]
