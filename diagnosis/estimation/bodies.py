"""Parameters that a machine can have: pseudo-inertias of bodies positive definite, masses, moments
of inertia and friction not negative.

    P = [[tr(J) 1/2 - J, mc], [mc^T, m]] > 0     [Wensing, Kim, Slotine 2017, Eq. (9)]

J (3, 3): moments about the joint. The estimate is the minimum of the fit's quadratic form over all
such values. P is linear in the ten parameters, so a barrier -mu (log det P + log x) keeps them
inside, and the problem convex: Newton's steps while mu falls find the only minimum, without a
solver for matrix inequalities, and what they give is definite [Boyd, Vandenberghe 2004, ch. 11].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known

Array = NDArray[np.float64]
TEN = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_yy", "J_xz", "J_yz", "J_zz")
GAP = 0.01
"""Sum of squares, in units of the noise, by which the answer may exceed the smallest."""
FALL, STEPS, SETTLED = 0.2, 60, 1e-8
"""Of mu from one minimum to the next; steps at most to one; the decrease, relative to mu, at which
it is one."""
MEAN = 1e-6
"""Smallest eigenvalue of a file's pseudo-inertia, relative to the mean: else the file describes no
body, and a round one of its mass and size stands for it."""


@dataclass(frozen=True)
class Body:
    """A body with all ten parameters: its name, and their places in the order of `TEN`."""

    name: str
    places: tuple[int, ...]


def bodies_of(known: Sequence[Known]) -> list[Body]:
    """Bodies among parameters: those of which all ten are there."""
    at = {k.name: place for place, k in enumerate(known)}
    owners = dict.fromkeys(k.name.rpartition(".")[0] for k in known if "." in k.name)
    bodies = []
    for owner in owners:
        places = [at.get(f"{owner}.{name}") for name in TEN]
        if None not in places:
            bodies.append(Body(owner, tuple(p for p in places if p is not None)))
    return bodies


def pseudo_inertia(ten: Array) -> Array:
    """P (4, 4) of the ten parameters of a body."""
    m, mc = ten[0], ten[1:4]
    J = np.array([[ten[4], ten[5], ten[7]], [ten[5], ten[6], ten[8]], [ten[7], ten[8], ten[9]]])
    P = np.empty((4, 4))
    P[:3, :3] = np.trace(J) / 2 * np.eye(3) - J
    P[:3, 3] = P[3, :3] = mc
    P[3, 3] = m
    return P


def ten_of(P: Array) -> Array:
    """The ten parameters of a pseudo-inertia (4, 4)."""
    S = P[:3, :3]
    J = np.trace(S) * np.eye(3) - S
    return np.array([P[3, 3], *P[:3, 3], J[0, 0], J[0, 1], J[1, 1], J[0, 2], J[1, 2], J[2, 2]])


BASIS = np.array([pseudo_inertia(row) for row in np.eye(10)])
"""Pseudo-inertias (10, 4, 4) of one of each parameter."""


def consistent(ten: Array) -> bool:
    """Whether a body can have these parameters."""
    return bool(least_share(ten) > 0)


def least_share(ten: Array) -> float:
    """Smallest eigenvalue of a pseudo-inertia in units of its own size: below zero for no body."""
    P = pseudo_inertia(ten)
    if not ten[0] > 0:
        return -1.0
    second = max(float(np.trace(P[:3, :3])) / ten[0], 1e-300)
    size = np.sqrt(ten[0] * np.array([second, second, second, 1.0]))
    return float(np.linalg.eigvalsh(P / np.outer(size, size))[0])


def nearest(ten: Array) -> Array:
    """The file's pseudo-inertia (4, 4), or where no body has it that of a round one."""
    if ten[0] > 0 and least_share(ten) > MEAN:
        return pseudo_inertia(ten)
    m = max(float(ten[0]), 1e-9)
    c = ten[1:4] / m
    about = float(np.trace(pseudo_inertia(ten)[:3, :3])) / m - float(c @ c)
    radius = max(about, 1e-2 * float(c @ c), 1e-8) / 3
    P = np.empty((4, 4))
    P[:3, :3] = m * (np.outer(c, c) + radius * np.eye(3))
    P[:3, 3] = P[3, :3] = m * c
    P[3, 3] = m
    return P


@dataclass(frozen=True)
class Possible:
    """Values that a machine can have (n,), and by how much their sum of squares exceeds the
    smallest, in units of the noise."""

    values: Array
    excess: float


def possible(
    values: Array, curvature: Array, bodies: Sequence[tuple[Body, Array]], positive: Sequence[int]
) -> Possible:
    """The nearest values that a machine can have: (v - values)^T curvature (v - values) least.

    What has no curvature is fixed where it is, or where the file's body has it.

    curvature (n, n); bodies: each with the ten values of its file, about which it starts; positive:
    places of parameters that are not negative, beside those of bodies.
    """
    outside = [k for k in positive if values[k] < 0]
    wrong = [body for body, _ in bodies if not consistent(values[list(body.places)])]
    if not outside and not wrong:
        return Possible(values, 0.0)
    barrier = _Barrier([(list(b.places), nearest(ten)) for b, ten in bodies], list(positive))
    x = barrier.start(values)
    count = 4 * len(bodies) + len(positive)
    mu = max(float((x - values) @ curvature @ (x - values)) / count, GAP / count)
    x = _minimum(x, values, curvature, mu, barrier)
    while 2 * mu * count > GAP:
        mu *= FALL
        x = _minimum(x, values, curvature, mu, barrier)
    return Possible(x, float((x - values) @ curvature @ (x - values)))


def _minimum(x: Array, values: Array, curvature: Array, mu: float, barrier: _Barrier) -> Array:
    """The minimum of |x - values|^2 / 2 + mu barrier, by Newton's steps with a line search."""

    def cost(at: Array) -> float:
        off = at - values
        return float(off @ curvature @ off) / 2 + mu * barrier.value(at)

    free, now = np.flatnonzero(np.diag(curvature) > 0), cost(x)
    for _ in range(STEPS):
        slope, bend = barrier.slopes(x)
        g, H = curvature @ (x - values) + mu * slope, curvature + mu * bend
        g, H = g[free], H[np.ix_(free, free)]
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled = H / np.outer(size, size) + np.diag(np.full(len(g), np.finfo(float).eps))
        step = np.zeros(len(x))
        step[free] = -np.linalg.solve(scaled, g / size) / size
        decrease, length = -float(g @ step[free]), 1.0
        if decrease < SETTLED * mu:
            break
        while (
            length > 1e-10 and not (then := cost(x + length * step)) < now - 0.1 * length * decrease
        ):
            length /= 2
        if length <= 1e-10:
            break
        x, now = x + length * step, then
    return x


class _Barrier:
    """-log det of each body's pseudo-inertia - log of each positive parameter.

    bodies: places and a pseudo-inertia (4, 4) that a body has.
    """

    def __init__(self, bodies: Sequence[tuple[list[int], Array]], positive: list[int]) -> None:
        self.bodies, self.positive = bodies, positive

    def start(self, values: Array) -> Array:
        """Values inside: of bodies those of their files."""
        x = values.copy()
        for places, own in self.bodies:
            x[places] = ten_of(own)
        inside = x[self.positive]
        x[self.positive] = np.where(inside > 0, inside, np.maximum(np.abs(inside), 1e-9))
        return x

    def value(self, x: Array) -> float:
        """Infinite outside."""
        total = 0.0
        for places, _ in self.bodies:
            try:
                L = np.linalg.cholesky(pseudo_inertia(x[places]))
            except np.linalg.LinAlgError:
                return np.inf
            total -= 2 * float(np.log(np.diag(L)).sum())
        own = x[self.positive]
        return np.inf if (own <= 0).any() else total - float(np.log(own).sum())

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """First and second derivatives (n,), (n, n)."""
        first, second = np.zeros(len(x)), np.zeros((len(x), len(x)))
        for places, _ in self.bodies:
            Q = np.linalg.inv(pseudo_inertia(x[places])) @ BASIS
            first[places] -= np.trace(Q, axis1=1, axis2=2)
            second[np.ix_(places, places)] += np.einsum("aij,bji->ab", Q, Q)
        first[self.positive] -= 1 / x[self.positive]
        second[self.positive, self.positive] += 1 / x[self.positive] ** 2
        return first, second
