"""The columns of a user's effect as CasADi expressions: called with symbols in place of numbers.

The user's method takes arrays of one sample whose elements are symbols. NumPy's arithmetic and
elementary functions, indexing and stacking work on them; what asks for a truth value does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.effects.effect import Shapes, Signals
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.user_code import error_line

Array = NDArray[np.float64]
NAMES = ("theta", "thetad", "thetadd", "tau", "taud", "time")
"""Signals of an axis, in the order of the search's arrays and of `function`."""
AXES = 6
"""Of a machine that FMUs are made for."""
ACCELERATION = 2
"""Place of thetadd."""
SAME = 1e-9
"""Difference of expression and numbers, relative to the largest column, that rounding makes."""
PROBES = 16
TRUTH = "Cannot compute the truth value"
"""What CasADi says of a comparison."""
MEND = (
    "It is called with symbols, one sample at a time: use arithmetic and NumPy's elementary"
    " functions (sin, tanh, abs, sqrt, stack), np.zeros_like in place of np.zeros, np.tanh(x / w)"
    " in place of np.sign and np.where, and no loop over samples"
)


def traced(columns: Callable[..., Any], s: Signals, shape: Shapes, name: str) -> ca.SX:
    """Columns (gains,) for symbols of one instant. MachineError where they work with numbers
    alone; name: how messages call the effect."""
    axis = _arrays(s)
    axis.others = [_arrays(other) for other in s.others]
    values = {k: _array(v) if isinstance(v, ca.SX) else float(v) for k, v in shape.items()}
    try:
        listed = np.asarray(columns(axis, **values)).ravel()
        return ca.vertcat(*(ca.SX(value) for value in listed))
    except Exception as error:
        raise MachineError(
            f"{name}: can be found, but not built: columns works with numbers alone:"
            f" {_said(error, columns)}. {MEND}"
        ) from error


def function(
    columns: Callable[[Signals, Shapes], ca.SX], shape: Shapes, n: int = AXES
) -> ca.Function:
    """Columns (gains,) of an axis for the signals (n + 1, 6) of it and of all axes, in a vector."""
    u, size = ca.SX.sym("u", (n + 1) * len(NAMES)), len(NAMES)
    rows = [u[k : k + size] for k in range(0, u.numel(), size)]
    each = [Signals(row[0], row[1], row[2], row[3], row[4], row[5]) for row in rows]
    return ca.Function("columns", [u], [columns(replace(each[0], others=tuple(each[1:])), shape)])


def probes(n: int) -> Array:
    """Small random signals (PROBES, 6 (n + 1)) at which expression and numbers are compared."""
    return 0.3 * np.random.default_rng(1).standard_normal((PROBES, (n + 1) * len(NAMES)))


def refuse_other(made: ca.Function, wanted: Array, name: str) -> None:
    """MachineError for an expression that gives other columns (PROBES, gains) than numbers do at
    `probes`, or one that the plant cannot solve for the accelerations."""
    u = ca.SX.sym("u", made.numel_in(0))
    if any(ca.which_depends(made(u), u, 2, False)[ACCELERATION :: len(NAMES)]):
        raise MachineError(
            f"{name}: can be found, but not built: columns must be linear in thetadd for the plant"
        )
    expressed = made(probes(u.numel() // len(NAMES) - 1).T).full().T
    if expressed.shape != wanted.shape or not (
        np.abs(expressed - wanted).max() <= SAME * np.abs(wanted).max()
    ):
        raise MachineError(
            f"{name}: can be found, but not built: called with symbols, columns gives others than"
            " with numbers; use each sample's signals alone"
        )


def _arrays(s: Signals) -> SimpleNamespace:
    return SimpleNamespace(**{name: _array(getattr(s, name)) for name in NAMES}, others=())


def _array(value: Any) -> NDArray[np.object_]:
    """One sample of an expression."""
    array = np.empty(1, dtype=object)
    array[0] = ca.SX(value)
    return array


def _said(error: Exception, columns: Callable[..., Any]) -> str:
    """An error and its line in the user's file; CasADi's say where in its own sources they are."""
    code = getattr(columns, "__code__", None)
    text = error_line(error, code.co_filename if code else "")
    return f"it asks whether a symbol is true{text[text.rfind(' (') :]}" if TRUTH in text else text
