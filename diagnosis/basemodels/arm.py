"""A serial arm of rigid links as base model of the diagnosis, friction left out on purpose.

    tau = sum over links of (body torque by Newton and Euler) + J_r thetadd

linear in mass, first and second moments of each link and in the rotor inertia J_r of each axis,
seen behind its gear; where a joint slides tau is a force, J_r a mass. Rotors are free. An offset is
left out, since it could pass for the friction of an axis that moves one way only. Viscous friction
is left out like dry friction: an arm with gears has much of both, and both are for the library to
find.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels import geometry
from flexhex.diagnosis.basemodels.base import Geometry, Known, Motion
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.basemodels.serial import Arm, misplacements, newton_euler
from flexhex.diagnosis.kinds import Kinds
from flexhex.numeric.rows import native

Array = NDArray[np.float64]
TEN = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_xz", "J_yy", "J_yz", "J_zz")
TEN_UNITS = ("kg", *("kg m",) * 3, *("kg m2",) * 6)
THICK = 0.05
"""Radius of gyration of a link about its own centre of mass [m]."""


class RigidArmBase(ColumnBase):
    """Base model of a serial arm sampled every ts [s]; see `Base`."""

    def __init__(self, arm: Arm, ts: float) -> None:
        self.arm, kinds = arm, tuple(link.kind for link in arm.links)
        super().__init__(kinds, (*_inertias(arm), *_rotors(kinds)), ts)
        self.payload = tuple(range(10 * (self.n - 1), 10 * self.n))
        self.rotors = tuple(range(10 * self.n, 11 * self.n))
        self.reach = float(sum(np.linalg.norm(link.at) for link in arm.links))
        n = self.n
        theta, thetad, thetadd = (ca.SX.sym(s, n) for s in ("theta", "thetad", "thetadd"))
        p = ca.SX.sym("p", len(self.linear))
        tau = self.symbolic(theta, thetad, thetadd, p)
        Phi = ca.jacobian(tau, p)
        sparsity = Phi.sparsity()
        self._at = np.array(sparsity.row()), np.array(sparsity.get_col())
        nonzeros: Any = Phi.nonzeros()
        entries = ca.vertcat(*nonzeros)
        moved = [theta, thetad, thetadd]
        functions = [ca.Function("native_arm", moved, [ca.cse(entries)])]
        errors = tuple(misplacements(arm)) if arm.misplaced else ()
        if errors:
            e = ca.SX.sym("e", len(errors))
            off = newton_euler(arm, theta, thetad, thetadd, p[: 10 * n], e)
            functions.append(geometry.pulled("native_misplaced", moved, p, e, off))
        self._entries, *pulled = native(functions)
        self.geometry: Geometry | None = None
        if errors:
            self.geometry = geometry.Derivatives(errors, _state, *pulled)

    def symbolic(self, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX) -> ca.SX:
        """Torques (n,) as an expression of the motion (n,) and the parameters."""
        bodies, rotors = p[: 10 * self.n], p[10 * self.n :]
        return newton_euler(self.arm, theta, thetad, thetadd, bodies) + rotors * thetadd

    def loaded(self, p: Array, payload: float) -> Array:
        """A point mass at the centre of the last link: where it is nobody says."""
        loaded = p.copy()
        loaded[list(self.payload)] += payload * np.array(_ten(1.0, self.arm.links[-1].centre, 0.0))
        return loaded

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, n_p)."""
        dense = np.zeros((weights.shape[0], self.n, len(self.linear)))
        dense[:, self._at[0], self._at[1]] = weights @ self._values(motion)
        return dense

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m, N]."""
        rows, cols = self._at
        pick = np.zeros((len(rows), self.n))
        pick[np.arange(len(rows)), rows] = p[cols]
        return np.asarray(self._values(motion) @ pick)

    def _values(self, motion: Motion) -> Array:
        """Nonzero columns (samples, nonzeros)."""
        (values,) = self._entries(motion.theta, motion.thetad, motion.thetadd)
        return values


def _state(motion: Motion) -> tuple[Array, Array, Array]:
    return motion.theta, motion.thetad, motion.thetadd


def _inertias(arm: Arm) -> list[Known]:
    listed = []
    for k, link in enumerate(arm.links, start=1):
        m, reach = link.mass, float(np.linalg.norm(link.centre)) + THICK
        ten = _ten(m, link.centre, THICK)
        # a body between a point at its centre of mass and a rod that ends twice as far away
        rod = m * float(np.dot(link.centre, link.centre)) / 3 if arm.spread else 0.0
        second = float(np.hypot(arm.spread * max(ten[4:]), rod))
        spreads = [arm.spread * m, *(arm.spread * m * reach,) * 3, *(second,) * 6]
        for name, unit, value, spread in zip(TEN, TEN_UNITS, ten, spreads, strict=True):
            name = f"link[{k}].{name}"
            listed.append(Known(name, unit, float(value), spread, name))
    return listed


def _ten(mass: float, centre: tuple[float, float, float], gyration: float) -> list[float]:
    """Parameters of a body, all radii of gyration about its centre of mass alike [m]."""
    c = np.array(centre)
    J = mass * (c @ c * np.eye(3) - np.outer(c, c)) + mass * gyration**2 * np.eye(3)
    return [mass, *(mass * c), *(float(J[i, j]) for i in range(3) for j in range(i, 3))]


def _rotors(kinds: Kinds) -> list[Known]:
    named = [(f"{kind.inertia}_r", kind.unit("kg m2")) for kind in kinds]
    return [
        Known(f"{name}[{i + 1}]", unit, 0.0, np.inf, name, i)
        for i, (name, unit) in enumerate(named)
    ]
