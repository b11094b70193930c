"""The torque of a base model as an expression, so that it can be compiled: written by the base
model itself, or traced through its columns, called with symbols in place of numbers.

    tau = columns(theta, thetad, thetadd) p
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.user_code import error_line
from flexhex.fmus.inverse.equations import Torque

Array = NDArray[np.float64]
ColumnsFunction = Callable[[Any, Any, Any], Any]
SAME = 1e-9
"""Difference of expression and numbers, relative to the largest torque, that rounding makes."""
PROBES = 16


def symbolic_torque(base: Base, name: str) -> Torque:
    """Torque (n,) from theta, thetad, thetadd (n,) and the parameters of `base.linear`.

    name: how messages call it. Raises MachineError where the model works with numbers alone, or
    where the expression gives other torques.
    """
    own: Torque | None = getattr(base, "symbolic", None)
    torque = own or _traced(base, name)
    _refuse_other(base, torque, name)
    return torque


def _traced(base: Base, name: str) -> Torque:
    columns: ColumnsFunction | None = getattr(base, "traceable", None)
    if columns is None:
        raise MachineError(f"{name}: cannot be compiled: no expression of it is known")

    def torque(theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX) -> ca.SX:
        moved = (np.array([v.elements()], dtype=object) for v in (theta, thetad, thetadd))
        try:
            traced = np.asarray(columns(*moved))
        except Exception as error:
            raise MachineError(
                f"{name}: cannot be compiled: columns works with numbers alone:"
                f" {error_line(error)}."
                " It is called with symbols: use arithmetic and NumPy's elementary functions (sin,"
                " tanh, abs, sqrt, stack), np.zeros_like in place of np.zeros, and no comparison"
            ) from error
        each = [sum(value * p[k] for k, value in enumerate(row)) for row in traced[0]]
        whole: ca.SX = ca.vertcat(*each)
        return whole

    return torque


def _refuse_other(base: Base, torque: Torque, name: str) -> None:
    """MachineError for an expression that gives other torques than the columns, at random."""
    rng, n, size = np.random.default_rng(0), base.n, len(base.linear)
    theta, thetad, thetadd = rng.standard_normal((3, PROBES, n))
    motion = Motion(0.0, 1.0, theta, thetad, thetadd)
    p = np.abs(rng.standard_normal(size)) + np.array([known.nominal for known in base.linear])
    q, v, a, given = (ca.SX.sym("", k) for k in (n, n, n, size))
    function = ca.Function("torque", [q, v, a, given], [torque(q, v, a, given)])
    moved = zip(theta, thetad, thetadd, strict=True)
    expressed = np.array([function.call([*each, p])[0].full().ravel() for each in moved])
    wanted = base.torque(motion, p)
    if not np.abs(expressed - wanted).max() <= SAME * np.abs(wanted).max():
        raise MachineError(
            f"{name}: cannot be compiled: called with symbols, columns gives other torques than"
            " with numbers"
        )
