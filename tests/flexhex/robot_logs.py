"""Logs of robots for tests of pages: the torques of a file, and friction that it lacks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.conftest import ROOT
from tests.diagnosis.robots.simulated import FILE, wanted

pin = pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
AXIS = ROOT / "examples" / "axis"
FIVE_BAR = ROOT / "examples" / "five_bar" / "five_bar.py"
RUBBED = 2.0
"""Friction of joint 3 that no file knows [N m]."""


def write(path: Path, t: Array, theta: Array, tau: Array, kinds: str = "") -> Path:
    """A log; kinds: a letter for each axis, `l` for one that slides."""
    n = theta.shape[1]
    names = [f"{name}[{i + 1}]" for name in ("theta", "tau_meas") for i in range(n)]
    of = kinds.ljust(n, "r")
    units = [*("m" if k == "l" else "rad" for k in of), *("N" if k == "l" else "N m" for k in of)]
    head = f"time,{','.join(names)}\ns,{','.join(units)}"
    rows = np.column_stack([t, theta, tau])
    np.savetxt(path, rows, delimiter=",", comments="", header=head, fmt="%.9g")
    return path


def arm_log(path: Path, seed: int, seconds: float = 6.0, delay: float = 5.0) -> Path:
    """The arm's own torques with friction on joint 3 and some noise; time begins at `delay` [s]."""
    t, rng = np.arange(round(seconds / 2e-3)) * 2e-3, np.random.default_rng(seed)
    model = pin.buildModelFromUrdf(str(FILE))
    data, moved = model.createData(), wanted(t, seed)
    # a joint without limits has sine and cosine for its angle
    q = [pin.integrate(model, pin.neutral(model), theta) for theta in moved[0]]
    tau = np.array([pin.rnea(model, data, *row) for row in zip(q, *moved[1:], strict=True)])
    tau[:, 2] += RUBBED * np.sign(moved[1][:, 2])
    tau += 1e-3 * np.ptp(tau, axis=0) * rng.standard_normal(tau.shape)
    return write(path, delay + t, moved[0] + 2e-6 * rng.standard_normal(tau.shape), tau)
