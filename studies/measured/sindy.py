"""PySINDy on a single axis, as a lab would use it."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.measured.others import Rows, relative_rms, rows
from studies.measured.sets import Measured

Array = NDArray[np.float64]
THRESHOLD = 0.02
"""Of PySINDy: RMS of the acceleration that a term makes [m/s2]; fainter ones are left out."""


def sindy(measured: Measured) -> dict[str, Any] | None:
    """PySINDy with control on a single axis: a = f(v, q, sign v) + u / m. None where it is not
    installed."""
    try:
        ps: Any = importlib.import_module("pysindy")
    except ImportError:
        return None
    parts = [rows(part, measured.cut) for part in (*measured.fit, *measured.test)]

    def library(r: Rows) -> Array:
        q, v = r.q[:, 0], r.v[:, 0]
        one = np.ones_like(v)
        return np.column_stack(
            [r.tau[:, 0], one, v, np.sign(v), v * np.abs(v), v**3, q, q**2, q * v]
        )

    names = ("u", "1", "v", "sign v", "v |v|", "v^3", "q", "q^2", "q v")
    X = library(parts[0])
    size = np.sqrt((X**2).mean(axis=0))
    optimizer = ps.STLSQ(threshold=THRESHOLD).fit(X / size, parts[0].a)
    w = np.ravel(optimizer.coef_) / size
    # a = w0 u + rest: the force is what the rest leaves of the acceleration
    each = [
        relative_rms((r.a[:, :1] - (library(r)[:, 1:] @ w[1:])[:, None]) / w[0], r.tau, r.v)
        for r in parts
    ]
    kept = {name: float(value) for name, value in zip(names, w, strict=True) if value}
    mass = 1 / w[0]
    return {
        "tool": f"PySINDy {ps.__version__}, STLSQ",
        "terms": [[name for name in kept if name != "u"]],
        "m": float(mass),
        "d": float(-mass * kept.get("v", 0.0)),
        "F_c": float(-mass * kept.get("sign v", 0.0)),
        "o": float(-mass * kept.get("1", 0.0)),
        "fit": each[0],
        "test": each[1],
    }
