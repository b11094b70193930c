"""Loop closure, rates and Dahl states along the samples of a log, compiled."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common import actuator
from flexhex.fmus.common.model.model import Model
from flexhex.numeric.rows import native
from flexhex.numeric.scan import ScanFunction, scans

Array = NDArray[np.float64]
NEWTON_STEPS = 8


class Closure:
    """All coordinates x~ of a machine and their rates from the joint angles alone."""

    def __init__(self, model: Model) -> None:
        self._n, self._x0 = model.n, model.frames.x0
        x = ca.SX.sym("x", model.n_x)
        thetad, thetadd = ca.SX.sym("thetad", model.n), ca.SX.sym("thetadd", model.n)
        linkage = model.linkage(x)
        newton = ca.vertcat(x[: model.n], linkage.newton())
        xd = linkage.rates(thetad)
        xdd = linkage.accelerations(xd, thetadd)
        self._newton, self._rates = native(
            [
                ca.Function("native_newton", [x], ca.cse([newton])),
                ca.Function("native_rates", [x, thetad, thetadd], ca.cse([xd, xdd])),
            ]
        )

    def solve(self, theta: Array) -> Array:
        """x~ (samples, n_x) for angles (samples, n), each solved from neutral."""
        x = np.tile(self._x0, (len(theta), 1))
        x[:, : self._n] = theta
        for _ in range(NEWTON_STEPS):
            (x,) = self._newton(x)
        return x

    def rates(self, x: Array, thetad: Array, thetadd: Array) -> tuple[Array, Array]:
        """xd, xdd (samples, n_x)."""
        xd, xdd = self._rates(x, thetad, thetadd)
        return xd, xdd


@cache
def dahl_scan(n: int) -> ScanFunction:
    """Dahl states (samples, n) along angles (samples, n) for widths sigma (n,)."""
    z, before, now, sigma = (ca.SX.sym(s, n) for s in ("z", "before", "now", "sigma"))
    z_next = [actuator.dahl(z[i], now[i] - before[i], sigma[i]) for i in range(n)]
    return scans([ca.Function("scan_dahl", [z, before, now, sigma], [ca.vertcat(*z_next)])])[0]
