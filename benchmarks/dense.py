"""The paper's dense form of the step N as compiled C: rival of the structured one."""

from __future__ import annotations

import casadi as ca

from benchmarks.blocks import HERE, Array, Instance, library
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.constraints import constraints
from flexhex.fmus.common.model.geometry import Frames


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of dense.c, by automatic differentiation of D.  [SH, Eq. (5), (9), (10)]

    dense_newton(x) -> D (31,), D_d (31, 31);  dense_rates(x) -> D, D_d, D_theta (31, 6)
    dense_curvature(x, xd) -> sum_jk d2D/dx_j dx_k xd_j xd_k (31,)
    """
    frames, n = Frames.of(machine), machine.n_arms
    x = ca.SX.sym("x", len(frames.x0))
    xd = ca.SX.sym("xd", x.numel())
    D = constraints(machine, frames, x)
    D_x = ca.jacobian(D, x)
    curvature = ca.jtimes(ca.jtimes(D, x, xd), x, xd)
    D_theta, D_d = ca.densify(D_x[:, :n]), ca.densify(D_x[:, n:])
    return [
        ca.Function("dense_newton", [x], ca.cse([D, D_d]), ["x"], ["D", "D_d"]),
        ca.Function("dense_rates", [x], ca.cse([D, D_d, D_theta]), ["x"], ["D", "D_d", "D_theta"]),
        ca.Function("dense_curvature", [x, xd], ca.cse([curvature]), ["x", "xd"], ["curvature"]),
        ca.Function("dense_neutral", [], [ca.SX(frames.x0)], [], ["x"]),
    ]


def interface(machine: Machine) -> Interface:
    """Inputs and outputs of the step N without its decisions."""
    n, n_x = machine.n_arms, len(Frames.of(machine).x0)
    variables = (
        Variable("theta", "input", "rad", "actuator angles", n),
        Variable("thetad", "input", "rad/s", "their rates", n),
        Variable("thetadd", "input", "rad/s2", "their accelerations", n),
        Variable("x", "output", "1", "coordinates", n_x),
        Variable("xd", "output", "1/s", "rates", n_x),
        Variable("xdd", "output", "1/s2", "accelerations", n_x),
        Variable("residual", "output", "1", "|D| after the correction"),
    )
    constants = {"N": n, "N_D": n_x - n}
    return Interface("dense", "dense N", machine.timing.feedforward, variables, constants)


def dense(machine: Machine, rows: Array) -> Instance:
    """A started instance of the dense form; compiled with -O3, which suits its loops."""
    described = interface(machine)
    path = library(described, functions(machine), HERE / "dense.c", flags=("-O3",))
    return Instance(path, described, rows)
