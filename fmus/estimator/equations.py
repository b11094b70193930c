"""Regressor E (26), (32) in the packed form that the Kalman filter K walks through."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.model import Model


def packed(Phi: ca.SX) -> tuple[ca.SX, NDArray[np.int64]]:
    """Rows of a sparse Phi (n, n_p) without their structural zeros.

    Returns phi (n * width,), row after row, and columns (n, width): where each value
    stands in Phi. Shorter rows are filled up with zeros in their last column.
    """
    sparsity = Phi.sparsity()
    rows, cols = (np.array(ix) for ix in (sparsity.row(), sparsity.get_col()))
    width = max(int((rows == i).sum()) for i in range(Phi.shape[0]))
    values, columns = [], np.zeros((Phi.shape[0], width), dtype=np.int64)
    for i in range(Phi.shape[0]):
        mine = cols[rows == i]
        values += [Phi[i, int(c)] for c in mine] + [ca.SX(0)] * (width - len(mine))
        columns[i, : len(mine)], columns[i, len(mine) :] = mine, mine[-1]
    return ca.vertcat(*values), columns


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c.

    estimator_regressor(x, xd, xdd, chi) -> phi (n * width,): rows of Phi, packed
    estimator_columns() -> columns (n * width,): their places in p, as whole doubles
    """
    model = Model(machine)
    x, xd, xdd = (ca.SX.sym(name, model.n_x) for name in ("x", "xd", "xdd"))
    chi = ca.SX.sym("chi", model.n * model.n_basis + model.bank.n_gains)
    phi, columns = packed(ca.cse(model.regressor(x, xd, xdd, chi)))
    return [
        ca.Function(
            "estimator_regressor", [x, xd, xdd, chi], [phi], ["x", "xd", "xdd", "chi"], ["phi"]
        ),
        ca.Function("estimator_columns", [], [ca.SX(columns.ravel())], [], ["columns"]),
    ]


def row_width(machine: Machine) -> int:
    """Largest number of structural nonzeros in a row of Phi."""
    model, own = Model(machine), 2 * machine.actuator.n_harmonics + 5
    effects = [part.axis for part, _ in model.bank.gains]
    most = max(effects.count(axis) for axis in range(model.n))
    return own + model.n_base - model.n * own + most
