"""Which parameters a base model's torques can tell apart at all, and what acts in their place.

    tau = W p,  W = W_1 [1, beta],  base parameters p_1 + beta p_2         [Gautier 1991]

W: columns at random rates and accelerations about angles of the runs. Columns are taken body by
body from the foot outwards, so that what hangs farther out stands beside what carries it, as in
`link_3.mc_x + 0.31 link_4.m`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.runs.blocks import Block

Array = NDArray[np.float64]
STATES, SEED = 400, 1
"""States at which the columns are compared; seed of their rates."""
DEPENDENT = 1e-7
"""Share of a column that is left beside those before it when it depends on them."""
NEGLIGIBLE = 1e-6
"""Coefficients of a combination that are rounding, in units of the columns' sizes."""
WITHIN, SAME = 1e-9, 1e-6
"""Singular values of the columns that count, relative to the largest; share of a further column
that is left beside them when it is one of their sums."""
LAST = ("J_xx", "J_yy", "J_zz", "J", "mc_z", "mc_y", "mc_x", "m", "J_r", "m_r")
"""Parameters of a body that are taken last, the latest last: what moves to the body before."""


@dataclass(frozen=True)
class Combination:
    """A base parameter: places in `linear` with their coefficients, the first with one."""

    terms: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Structure:
    """combinations: base parameters; silent: places of parameters that no torque feels."""

    combinations: tuple[Combination, ...]
    silent: tuple[int, ...]


def states(base: Base, blocks: Sequence[Block]) -> Motion:
    """Angles of the runs with random rates and accelerations of the runs' size (STATES, n)."""
    moved = [block.run.motion for block in blocks]
    theta, thetad, thetadd = (
        np.concatenate([getattr(m, name) for m in moved]) for name in ("theta", "thetad", "thetadd")
    )
    rng = np.random.default_rng(SEED)
    sizes = [np.sqrt((v**2).mean(axis=0)) + 1e-12 for v in (thetad, thetadd)]
    chosen = theta[rng.integers(0, len(theta), STATES)]
    # beside the path: angles of one run alone may go together
    chosen = chosen + 0.1 * theta.std(axis=0) * rng.standard_normal(chosen.shape)
    rates = [size * rng.standard_normal(chosen.shape) for size in sizes]
    return Motion(0.0, 1.0, chosen, *rates)


def structure(base: Base, blocks: Sequence[Block]) -> Structure:
    """Base parameters of a base model for motions like those of the runs."""
    W = _columns(base, states(base, blocks)).reshape(-1, len(base.linear))
    size = np.linalg.norm(W, axis=0)
    # relative to the largest torque that one tolerance or one unit of any parameter makes
    silent = tuple(int(k) for k in np.flatnonzero(size <= 1e-12 * size.max()))
    order = [k for k in _order(base) if k not in silent]
    chosen, basis, dependent = list[int](), np.zeros((len(W), 0)), list[int]()
    for k in order:
        column = W[:, k] / size[k]
        for _ in range(2):  # twice is enough: Gram and Schmidt
            column = column - basis @ (basis.T @ column)
        left = np.linalg.norm(column)
        if left < DEPENDENT:
            dependent.append(k)
        else:
            chosen.append(k)
            basis = np.column_stack([basis, column / left])
    beta = np.linalg.lstsq(W[:, chosen] / size[chosen], W[:, dependent] / size[dependent])[0]
    combinations = []
    for row, k in enumerate(chosen):
        terms = [(k, 1.0)]
        for column, other in enumerate(dependent):
            if abs(beta[row, column]) > NEGLIGIBLE:
                terms.append((other, float(beta[row, column] * size[other] / size[k])))
        combinations.append((k, Combination(tuple(terms))))
    return Structure(tuple(c for _, c in sorted(combinations, key=lambda pair: pair[0])), silent)


@dataclass(frozen=True)
class Span:
    """All torques of a base model at some states: an orthonormal basis (rows, rank) of them."""

    motion: Motion
    basis: Array

    @staticmethod
    def of(base: Base, blocks: Sequence[Block]) -> Span:
        """Of a base model about the angles of the runs."""
        motion = states(base, blocks)
        W = _columns(base, motion).reshape(-1, len(base.linear))
        W = W / np.maximum(np.linalg.norm(W, axis=0), np.finfo(float).tiny)
        u, s, _ = np.linalg.svd(W, full_matrices=False)
        return Span(motion, u[:, s > WITHIN * s[0]])

    def holds(self, axis: int, of_rate: Callable[[Array], Array]) -> bool:
        """Whether a torque on one axis that depends on its rate is among them."""
        column = np.zeros_like(self.motion.theta)
        column[:, axis] = of_rate(self.motion.thetad[:, axis])
        flat = column.ravel() / np.linalg.norm(column)
        return bool(np.linalg.norm(flat - self.basis @ (self.basis.T @ flat)) < SAME)


def _columns(base: Base, motion: Motion) -> Array:
    return base.rows(motion, csr_array(eye_array(len(motion.theta))))


def _order(base: Base) -> list[int]:
    """Places of the parameters, body by body, in a body those last that move to others."""
    owners = list(dict.fromkeys(_split(known.name)[0] for known in base.linear))

    def rank(place: int) -> tuple[int, int, int]:
        owner, own = _split(base.linear[place].name)
        late = LAST.index(own) + 1 if own in LAST else 0
        return owners.index(owner), late, place

    return sorted(range(len(base.linear)), key=rank)


def _split(name: str) -> tuple[str, str]:
    """Body and parameter: `link_3`, `mc_x`; rotors and the like are of no body."""
    body, dot, own = name.rpartition(".")
    return (body, own) if dot else ("", name.partition("[")[0])
