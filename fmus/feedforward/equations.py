"""Feedforward F: the inverse dynamics (24) at the wanted motion, (31)."""

from __future__ import annotations

import casadi as ca

from fmus.common.machine import Machine
from fmus.common.model import Model


def functions(machine: Machine) -> list[ca.Function]:
    """feedforward_torque(x, xd, xdd, z, p) -> tau_ff (6,) [N m].  [SH, Eq. (31)]"""
    model = Model(machine)
    x, xd, xdd = (ca.SX.sym(name, model.n_x) for name in ("x", "xd", "xdd"))
    z, p = ca.SX.sym("z", model.n), ca.SX.sym("p", model.n_p)
    tau = model.inverse_dynamics(x, xd, xdd, model.basis(x[: model.n], z), p)
    return [
        ca.Function(
            "feedforward_torque",
            [x, xd, xdd, z, p],
            ca.cse([tau]),
            ["x", "xd", "xdd", "z", "p"],
            ["tau_ff"],
        )
    ]
