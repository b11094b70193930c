"""CasADi functions with a state, compiled for NumPy and run along the samples of a log."""

from __future__ import annotations

import ctypes
import hashlib
import tempfile
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen.codegen import casadi_source
from flexhex.fmugen.compile import compile_object, link_shared
from flexhex.numeric.rows import DEFAULT_CACHE

Array = NDArray[np.float64]
_SCAN = """
int scan_{name}_sx(const double **arg, double **res, int *iw, double *w, int mem);
void {name}_along(long rows, const double *inputs, const double *fixed, double *states) {{
  for (long k = 1; k < rows; ++k) {{
    const double *arg[] = {{states + (k - 1) * {n_state}, inputs + (k - 1) * {n_input},
                           inputs + k * {n_input}, fixed}};
    double *res[] = {{states + k * {n_state}}};
    scan_{name}_sx(arg, res, 0, 0, 0);
  }}
}}
"""


class ScanFunction:
    """next = f(state, inputs before, inputs now, fixed) from sample to sample."""

    def __init__(self, library: ctypes.CDLL, function: ca.Function) -> None:
        self._call = getattr(library, f"{_short(function)}_along")
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
        self._call(
            ctypes.c_long(len(inputs)),
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (inputs, fixed, states)),
        )
        return states


def scans(functions: Sequence[ca.Function], cache: Path = DEFAULT_CACHE) -> list[ScanFunction]:
    """SX functions named `scan_<what>` of (state, before, now, fixed), compiled into `cache`.

    Raises BuildError when there is no compiler or it fails.
    """
    text = casadi_source(functions, "scan", "scan") + "".join(_loop(f) for f in functions)
    library = cache / f"scan-{hashlib.sha256(text.encode()).hexdigest()[:24]}.so"
    if not library.exists():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as folder:
            source = Path(folder) / "scan.c"
            source.write_text(text, encoding="utf-8")
            link_shared([compile_object(source, "", cache)], library)
    loaded = ctypes.CDLL(str(library.resolve()))
    return [ScanFunction(loaded, function) for function in functions]


def _short(function: ca.Function) -> str:
    return str(function.name()).removeprefix("scan_")


def _loop(function: ca.Function) -> str:
    n_state, n_input = function.numel_in(0), function.numel_in(1)
    return _SCAN.format(name=_short(function), n_state=n_state, n_input=n_input)
