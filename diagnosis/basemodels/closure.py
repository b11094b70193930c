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
"""From neutral to rounding, within the stroke."""
STRIDE, POLISH = 8, 2
"""Samples from one that is solved from neutral to the next, and steps of those between, which
begin at the line between the two: 1e-4 off, then 1e-8, then 1e-16."""
SETTLED = 1e-7
"""A last step (Newton's method squares it) beyond which a sample is solved from neutral as well:
angles that jump between two samples."""


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
        """x~ (samples, n_x) along angles (samples, n)."""
        count = len(theta)
        known = np.unique(np.append(np.arange(0, count, STRIDE), count - 1))
        neutral = np.tile(self._x0, (count, 1))
        coarse, _ = self._near(neutral[known], theta[known], NEWTON_STEPS)
        x, last = self._near(_between(known, coarse, count), theta, POLISH)
        far = last > SETTLED
        x[far], _ = self._near(neutral[far], theta[far], NEWTON_STEPS)
        return x

    def _near(self, x: Array, theta: Array, steps: int) -> tuple[Array, Array]:
        """The same from coordinates x (samples, n_x) nearby, and the last step (samples,)."""
        x[:, : self._n] = theta
        before = x
        for _ in range(steps):
            before, (x,) = x, self._newton(x)
        return x, np.abs(x - before).max(axis=1)

    def rates(self, x: Array, thetad: Array, thetadd: Array) -> tuple[Array, Array]:
        """xd, xdd (samples, n_x)."""
        xd, xdd = self._rates(x, thetad, thetadd)
        return xd, xdd


def _between(known: Array, values: Array, count: int) -> Array:
    """Values (count, ...) on the lines between those of the samples `known`."""
    samples = np.arange(count)
    after = np.clip(np.searchsorted(known, samples), 1, max(len(known) - 1, 1)) % len(known)
    before = np.maximum(after - 1, 0)
    part = (samples - known[before]) / np.maximum(known[after] - known[before], 1)
    return np.asarray(values[before] + part[:, None] * (values[after] - values[before]))


@cache
def dahl_scan(n: int) -> ScanFunction:
    """Dahl states (samples, n) along angles (samples, n) for widths sigma (n,)."""
    z, before, now, sigma = (ca.SX.sym(s, n) for s in ("z", "before", "now", "sigma"))
    z_next = [actuator.dahl(z[i], now[i] - before[i], sigma[i]) for i in range(n)]
    return scans([ca.Function("scan_dahl", [z, before, now, sigma], [ca.vertcat(*z_next)])])[0]
