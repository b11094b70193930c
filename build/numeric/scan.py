"""CasADi functions with a state, compiled for NumPy and run along the samples of a log."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from flexhex.numeric.library import Array, pointer, short, with_loops

_SCAN = """
int scan_{name}_sx(const double **arg, double **res, int *iw, double *w, int mem);
int scan_{name}_first_sx(const double **arg, double **res, int *iw, double *w, int mem);
void {name}_along(long rows, const double *inputs, const double *fixed, double *states) {{
  double once[{n_once}];
  const double *given[] = {{fixed}};
  double *first[] = {{once}};
  scan_{name}_first_sx(given, first, 0, 0, 0);
  for (long k = 1; k < rows; ++k) {{
    const double *arg[] = {{states + (k - 1) * {n_state}, inputs + (k - 1) * {n_input},
                           inputs + k * {n_input}, once}};
    double *res[] = {{states + k * {n_state}}};
    scan_{name}_sx(arg, res, 0, 0, 0);
  }}
}}
"""


class ScanFunction:
    """next = f(state, inputs before, inputs now, fixed) from sample to sample."""

    def __init__(self, library: ctypes.CDLL, function: ca.Function) -> None:
        self._call = getattr(library, f"{short(function)}_along")
        self._call.restype = None
        self._sizes = [function.numel_in(k) for k in range(4)]

    def __call__(self, start: Array, inputs: Array, fixed: Array) -> Array:
        """States (rows, n_state) along inputs (rows, n_input), the first one `start`.

        ValueError when shapes do not fit.
        """
        n_state, n_input, _, n_fixed = self._sizes
        inputs = np.ascontiguousarray(inputs, dtype=np.float64)
        fixed = np.ascontiguousarray(fixed, dtype=np.float64)
        if inputs.shape[1:] != (n_input,) or fixed.shape != (n_fixed,):
            raise ValueError(f"inputs {inputs.shape}, fixed {fixed.shape}; wants {self._sizes}")
        states = np.empty((len(inputs), n_state))
        states[0] = start
        self._call(ctypes.c_long(len(inputs)), *map(pointer, (inputs, fixed, states)))
        return states


def scans(functions: Sequence[ca.Function], cache: Path | None = None) -> list[ScanFunction]:
    """SX functions named `scan_<what>` of (state, before, now, fixed), compiled into `cache`. What
    goes with `fixed` alone is computed once for all samples.

    Raises BuildError when there is no compiler or it fails.
    """
    parts = [_parted(function) for function in functions]
    loops = [_loop(step, first) for step, first in parts]
    library = with_loops([f for pair in parts for f in pair], loops, "scan", cache)
    return [ScanFunction(library, function) for function in functions]


def _parted(function: ca.Function) -> tuple[ca.Function, ca.Function]:
    """A step whose last input is `fixed` and all that follows from it, and that of `fixed`."""
    *inputs, fixed = function.sx_in()
    step, symbols, values = ca.extract_parametric(ca.cse(function(*inputs, fixed)), fixed)
    once, first = ca.vertcat(fixed, *symbols), ca.vertcat(fixed, *values)
    name = function.name()
    return (
        ca.Function(name, [*inputs, once], [step]),
        ca.Function(f"{name}_first", [fixed], [first]),
    )


def _loop(step: ca.Function, first: ca.Function) -> str:
    return _SCAN.format(
        name=short(step),
        n_state=step.numel_in(0),
        n_input=step.numel_in(1),
        n_once=first.numel_out(0),
    )
