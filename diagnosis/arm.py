"""A serial arm of rigid links as base model of the diagnosis, friction left out on purpose.

    tau = sum over links of (body torque by Newton and Euler) + J_r thetadd

linear in mass, first and second moments of each link and in the rotor inertia J_r of each axis,
seen behind its gear. Rotors are free. An offset is left out, since it could
pass for the friction of an axis that moves one way only. Viscous friction is left out like dry
friction: an arm with gears has much of both, and both are for the library to find.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.base import LATE, Known, Motion
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.numeric.rows import native

Array = NDArray[np.float64]
TEN = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_xz", "J_yy", "J_yz", "J_zz")
AS_BODIES = (0, 3, 5, 1, 2, 4)
"""Where J_xx, J_yy, J_zz, J_xy, J_xz, J_yz stand among the six J of TEN."""
TEN_UNITS = ("kg", *("kg m",) * 3, *("kg m2",) * 6)
THICK = 0.05
"""Radius of gyration of a link about its own centre of mass [m]."""


@dataclass(frozen=True)
class Link:
    """A link that turns about its own z axis.

    at (3,) [m], rpy (3,) [rad]: where its axis stands in the link before (x, then y, then z of
    the fixed frame); mass [kg]; centre (3,) [m] of mass in its own frame.
    """

    at: tuple[float, float, float]
    rpy: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Arm:
    """Links from the foot on; gravity (3,) [m/s2] as far as the reported torques carry it.

    spread: tolerance of masses and moments, relative; 0 where the runs cannot better them.
    """

    links: tuple[Link, ...]
    gravity: tuple[float, float, float]
    spread: float = 0.0


def newton_euler(arm: Arm, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX) -> ca.SX:
    """Torques (n,) [N m] of links with ten parameters each, p (10 n,).

    Outward: rates and accelerations of each link's origin in its own frame; inward:
        f = m a + (S(wd) + S(w) S(w)) mc
        n = S(mc) a + J wd + S(w) J w        about the link's origin
    Gravity enters as an acceleration of the foot.  [Featherstone, Rigid Body Dynamics, 2008, ch. 5]
    """
    S = ca.skew
    z = ca.SX([0, 0, 1])
    w, wd, a = ca.SX.zeros(3), ca.SX.zeros(3), -ca.SX(list(arm.gravity))
    turns, arms, forces, moments = [], [], [], []
    for k, link in enumerate(arm.links):
        R = ca.mtimes(ca.SX(_rotation(link.rpy)), _about_z(theta[k]))
        r = ca.SX(list(link.at))
        a = ca.mtimes(R.T, a + ca.cross(wd, r) + ca.cross(w, ca.cross(w, r)))
        before = ca.mtimes(R.T, w)
        w = before + z * thetad[k]
        wd = ca.mtimes(R.T, wd) + z * thetadd[k] + ca.cross(before, z * thetad[k])
        ten = p[10 * k : 10 * k + 10]
        mc, J = ten[1:4], ca.blockcat(inertia_rows([ten[4 + j] for j in AS_BODIES]))
        forces.append(ten[0] * a + ca.mtimes(S(wd) + ca.mtimes(S(w), S(w)), mc))
        moments.append(ca.cross(mc, a) + ca.mtimes(J, wd) + ca.cross(w, ca.mtimes(J, w)))
        turns.append(R)
        arms.append(r)
    tau: list[ca.SX] = []
    f, n = ca.SX.zeros(3), ca.SX.zeros(3)
    for k in reversed(range(len(arm.links))):
        f, n = f + forces[k], n + moments[k]
        tau.insert(0, n[2])
        f = ca.mtimes(turns[k], f)
        n = ca.mtimes(turns[k], n) + ca.cross(arms[k], f)
    return ca.vertcat(*tau)


class RigidArmBase:
    """Base model of a serial arm sampled every ts [s]; see `flexhex.diagnosis.base.Base`."""

    settle = 0.0
    curved: tuple[Known, ...] = ()
    widths: tuple[Known, ...] = ()
    late = LATE
    holds: frozenset[str] = frozenset()
    given: tuple[EffectUse, ...] = ()
    complete = False

    def __init__(self, arm: Arm, ts: float) -> None:
        self.arm, self.n = arm, len(arm.links)
        self.window = max(0.0105, 16 * ts)
        self.spacing = max(0.005, 2 * ts)
        self.linear = (*_inertias(arm), *_rotors(self.n))
        self.payload = tuple(range(10 * (self.n - 1), 10 * self.n))
        self.reach = float(sum(np.linalg.norm(link.at) for link in arm.links))
        n = self.n
        theta, thetad, thetadd = (ca.SX.sym(s, n) for s in ("theta", "thetad", "thetadd"))
        p = ca.SX.sym("p", len(self.linear))
        tau = newton_euler(arm, theta, thetad, thetadd, p[: 10 * n]) + p[10 * n :] * thetadd
        Phi = ca.jacobian(tau, p)
        sparsity = Phi.sparsity()
        self._at = np.array(sparsity.row()), np.array(sparsity.get_col())
        nonzeros: Any = Phi.nonzeros()
        entries = ca.vertcat(*nonzeros)
        moved = [theta, thetad, thetadd]
        (self._entries,) = native([ca.Function("native_arm", moved, [ca.cse(entries)])])

    def loaded(self, p: Array, payload: float) -> Array:
        """A point mass at the centre of the last link: where it is nobody says."""
        found = p.copy()
        found[list(self.payload)] += payload * np.array(_ten(1.0, self.arm.links[-1].centre, 0.0))
        return found

    def directions(self) -> Mapping[str, Array]:
        """Masses are guesses: nothing more may change together."""
        return {}

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, n_p)."""
        dense = np.zeros((weights.shape[0], self.n, len(self.linear)))
        dense[:, self._at[0], self._at[1]] = weights @ self._values(motion)
        return dense

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """No curved terms."""
        empty = np.zeros((len(motion.theta), 0))
        return empty, empty

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m]."""
        rows, cols = self._at
        pick = np.zeros((len(rows), self.n))
        pick[np.arange(len(rows)), rows] = p[cols]
        return np.asarray(self._values(motion) @ pick)

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """Masses that are guesses cannot tell a tilted foot."""
        return {}

    def _values(self, motion: Motion) -> Array:
        """Nonzero columns (samples, nonzeros)."""
        (values,) = self._entries(motion.theta, motion.thetad, motion.thetadd)
        return values


def _inertias(arm: Arm) -> list[Known]:
    listed = []
    for k, link in enumerate(arm.links, start=1):
        m, reach = link.mass, float(np.linalg.norm(link.centre)) + THICK
        ten = _ten(m, link.centre, THICK)
        size = [m, *(m * reach,) * 3, *(max(ten[4:]),) * 6]
        for name, unit, value, one in zip(TEN, TEN_UNITS, ten, size, strict=True):
            name = f"link[{k}].{name}"
            listed.append(Known(name, unit, float(value), arm.spread * one, name))
    return listed


def _ten(mass: float, centre: tuple[float, float, float], gyration: float) -> list[float]:
    """Parameters of a body, all radii of gyration about its centre of mass alike [m]."""
    c = np.array(centre)
    J = mass * (c @ c * np.eye(3) - np.outer(c, c)) + mass * gyration**2 * np.eye(3)
    return [mass, *(mass * c), *(float(J[i, j]) for i in range(3) for j in range(i, 3))]


def _rotors(n: int) -> list[Known]:
    return [Known(f"J_r[{i + 1}]", "kg m2", 0.0, np.inf, "J_r", i) for i in range(n)]


def _rotation(rpy: tuple[float, float, float]) -> Array:
    """Rotation (3, 3) about fixed x, then y, then z."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(rpy), np.cos(rpy)
    X = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(Z @ Y @ X)


def _about_z(angle: ca.SX) -> ca.SX:
    s, c = ca.sin(angle), ca.cos(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.SX([[0, 0, 1]]))
