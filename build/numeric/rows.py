"""CasADi functions compiled for NumPy: the same C as in the FMUs, mapped over rows.

CasADi's interpreter and its conversions to NumPy take some 50 us a sample; a log of 50 s has
100 000 of them.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from flexhex.numeric.library import Array, short, with_loops

_MAP = """
int native_{name}_sx(const double **arg, double **res, int *iw, double *w, int mem);
void {name}_map(long rows, const double **arg, double **res) {{
  static const long in[] = {{{ins}}}, out[] = {{{outs}}};
  const double *a[{n_in}];
  double *r[{n_out}];
  for (long k = 0; k < rows; ++k) {{
    for (int i = 0; i < {n_in}; ++i) {{ a[i] = arg[i] + k * in[i]; }}
    for (int i = 0; i < {n_out}; ++i) {{ r[i] = res[i] + k * out[i]; }}
    native_{name}_sx(a, r, 0, 0, 0);
  }}
}}
"""


class RowFunction:
    """One function over rows: inputs (rows, size) each, outputs likewise, vectors only."""

    def __init__(self, library: ctypes.CDLL, function: ca.Function) -> None:
        self._call = getattr(library, f"{short(function)}_map")
        self._call.restype = None
        self._ins = [function.numel_in(k) for k in range(function.n_in())]
        self._outs = [function.numel_out(k) for k in range(function.n_out())]

    def __call__(self, *arguments: Array) -> list[Array]:
        """Evaluate every row. ValueError when shapes do not fit."""
        rows = len(arguments[0])
        ins = [np.ascontiguousarray(a, dtype=np.float64) for a in arguments]
        for k, (array, size) in enumerate(zip(ins, self._ins, strict=True)):
            if array.shape != (rows, size):
                raise ValueError(f"input {k + 1} has shape {array.shape}, wants {(rows, size)}")
        outs = [np.empty((rows, size)) for size in self._outs]
        self._call(ctypes.c_long(rows), _pointers(ins), _pointers(outs))
        return outs


def native(functions: Sequence[ca.Function], cache: Path | None = None) -> list[RowFunction]:
    """SX functions named `native_<what>`, compiled; libraries are kept in `cache`,
    by default the user's.

    Raises BuildError when there is no compiler or it fails.
    """
    library = with_loops(functions, [_map(f) for f in functions], "native", cache)
    return [RowFunction(library, function) for function in functions]


def _map(function: ca.Function) -> str:
    ins = [str(function.numel_in(k)) for k in range(function.n_in())]
    outs = [str(function.numel_out(k)) for k in range(function.n_out())]
    return _MAP.format(
        name=short(function),
        ins=", ".join(ins),
        outs=", ".join(outs),
        n_in=len(ins),
        n_out=len(outs),
    )


def _pointers(arrays: Sequence[Array]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
