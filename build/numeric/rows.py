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
void {name}_map(long rows, const double **arg, const long *in, double **res) {{
  static const long out[] = {{{outs}}};
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
        """Evaluate every row. An input that is the same in all is best given as `alike`.

        ValueError when shapes do not fit.
        """
        rows = len(arguments[0])
        for k, (array, size) in enumerate(zip(arguments, self._ins, strict=True)):
            if array.shape != (rows, size):
                raise ValueError(f"input {k + 1} has shape {array.shape}, wants {(rows, size)}")
        same = [rows > 1 and array.strides[0] == 0 for array in arguments]
        ins = [
            np.ascontiguousarray(array[:1] if one else array, dtype=np.float64)
            for array, one in zip(arguments, same, strict=True)
        ]
        steps = [0 if one else size for one, size in zip(same, self._ins, strict=True)]
        outs = [np.empty((rows, size)) for size in self._outs]
        step = (ctypes.c_long * len(steps))(*steps)
        self._call(ctypes.c_long(rows), _pointers(ins), step, _pointers(outs))
        return outs


def alike(values: Array, rows: int) -> Array:
    """The same values (size,) in each of so many rows, without a copy for each."""
    one = np.ascontiguousarray(values, dtype=np.float64)
    # what `broadcast_to` gives takes longer than many a function of a short log
    return np.ndarray((rows, len(one)), np.float64, one, strides=(0, one.itemsize))


def native(functions: Sequence[ca.Function], cache: Path | None = None) -> list[RowFunction]:
    """SX functions named `native_<what>`, compiled; libraries are kept in `cache`,
    by default the user's.

    Raises BuildError when there is no compiler or it fails.
    """
    library = with_loops(functions, [_map(f) for f in functions], "native", cache)
    return [RowFunction(library, function) for function in functions]


def _map(function: ca.Function) -> str:
    outs = [str(function.numel_out(k)) for k in range(function.n_out())]
    return _MAP.format(
        name=short(function),
        outs=", ".join(outs),
        n_in=function.n_in(),
        n_out=len(outs),
    )


def _pointers(arrays: Sequence[Array]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(
        *(array.__array_interface__["data"][0] for array in arrays)
    )
