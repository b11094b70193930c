"""The closure solved as the paper has it, to compare the structured solves with."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.constraints import constraints
from flexhex.fmus.common.model.geometry import Frames


@dataclass(frozen=True)
class DenseForm:
    """The paper's dense form: Newton correction and rates by a general 31 x 31 solve.

    newton(x) -> d; rates(x, thetad, thetadd) -> xd, xdd; residual(x) -> D, jacobian(x) -> D_x.
    """

    residual: ca.Function
    jacobian: ca.Function
    newton: ca.Function
    rates: ca.Function

    @staticmethod
    def of(machine: Machine) -> DenseForm:
        """Build the dense form of a machine by automatic differentiation of D."""
        frames, n = Frames.of(machine), machine.n_arms
        x = ca.SX.sym("x", len(frames.x0))
        xd = ca.SX.sym("xd", x.numel())
        D = constraints(machine, frames, x)
        D_x = ca.jacobian(D, x)
        curvature = ca.jtimes(ca.jtimes(D, x, xd), x, xd)
        residual = ca.Function("D", [x], [D])
        jacobian = ca.Function("D_x", [x], [D_x])
        quadratic = ca.Function("D_xx", [x, xd], [curvature])
        X, rate, acceleration = ca.MX.sym("x", x.numel()), ca.MX.sym("r", n), ca.MX.sym("a", n)
        J = jacobian(X)
        D_theta, D_d = J[:, :n], J[:, n:]
        newton = ca.Function("newton", [X], [X[n:] - ca.solve(D_d, residual(X))])
        Xd = ca.vertcat(rate, -ca.solve(D_d, D_theta @ rate))
        gamma = -ca.solve(D_d, quadratic(X, Xd))
        Xdd = ca.vertcat(acceleration, gamma - ca.solve(D_d, D_theta @ acceleration))
        rates = ca.Function("rates", [X, rate, acceleration], [Xd, Xdd])
        return DenseForm(residual, jacobian, newton, rates)
