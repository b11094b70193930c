"""Small linear solves as straight-line expressions, without pivoting.

Orthogonalisation needs no pivots, so one sequence of operations serves every pose: the
generated C has no branch and takes the same time at every step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca


def reciprocal(x: ca.SX) -> ca.SX:
    """1 / x, to the last bit, as a value of its own.

    CasADi makes b / x of every b * (1 / x): one division becomes many, and they are what costs
    most. It leaves 2 / x alone.
    """
    return 0.5 * (2 / x)


def total(terms: Sequence[ca.SX]) -> ca.SX:
    """Sum in pairs, 0 of none: a processor need not wait for one addition after the other."""
    while len(terms) > 1:
        pairs = [a + b for a, b in zip(terms[::2], terms[1::2], strict=False)]
        terms = [*pairs, *terms[len(terms) - len(terms) % 2 :]]
    return terms[0] if terms else ca.SX(0)


def dot(a: ca.SX, b: ca.SX) -> ca.SX:
    """a . b of columns, summed in pairs."""
    return total([a[k] * b[k] for k in range(a.numel())])


@dataclass(frozen=True)
class RowFactor:
    """A = L Q, rows of Q orthogonal, L lower triangular with ones; for a regular A (n, n).

    per_square: 1 / |Q_i|^2; the rows keep their length, so there is no root to wait for.
    solve(b): A x = b;  solve_transposed(b): A^T x = b.
    """

    L: list[list[ca.SX]]
    Q: list[ca.SX]
    per_square: list[ca.SX]

    @staticmethod
    def of(A: ca.SX) -> RowFactor:
        """Modified Gram-Schmidt on the rows of A."""
        n = A.shape[0]
        L: list[list[ca.SX]] = [[ca.SX(0)] * n for _ in range(n)]
        Q: list[ca.SX] = []
        per_square: list[ca.SX] = []
        for i in range(n):
            row = A[i, :].T
            for j in range(i):
                L[i][j] = dot(row, Q[j]) * per_square[j]
                row = row - L[i][j] * Q[j]
            per_square.append(reciprocal(dot(row, row)))
            Q.append(row)
        return RowFactor(L, Q, per_square)

    def solve(self, b: ca.SX) -> ca.SX:
        """x (n,) of A x = b: forward substitution y = L^-1 b, then x = Q^-1 y."""
        y: list[ca.SX] = []
        for i in range(len(self.Q)):
            left = b[i]
            for j in range(i):
                left = left - self.L[i][j] * y[j]
            y.append(left)
        return total([q * (a * per) for q, a, per in zip(self.Q, y, self.per_square, strict=True)])

    def solve_transposed(self, b: ca.SX) -> ca.SX:
        """x (n,) of A^T x = b: y = Q^-T b, then backward substitution."""
        n = len(self.Q)
        x: list[ca.SX] = [ca.SX(0)] * n
        for i in reversed(range(n)):
            x[i] = dot(self.Q[i], b) * self.per_square[i]
            for j in reversed(range(i + 1, n)):
                x[i] = x[i] - self.L[j][i] * x[j]
        return ca.vertcat(*x)


def solve_symmetric(M: ca.SX, b: ca.SX) -> ca.SX:
    """x (n,) of M x = b for a symmetric positive definite M (n, n), by L D L^T."""
    n = M.shape[0]
    L: list[list[ca.SX]] = [[ca.SX(0)] * n for _ in range(n)]
    scaled: list[list[ca.SX]] = [[ca.SX(0)] * n for _ in range(n)]
    inverse: list[ca.SX] = []
    for i in range(n):
        for j in range(i):
            scaled[i][j] = M[i, j] - sum(scaled[i][k] * L[j][k] for k in range(j))
            L[i][j] = scaled[i][j] * inverse[j]
        inverse.append(reciprocal(M[i, i] - sum(scaled[i][k] * L[i][k] for k in range(i))))
    y: list[ca.SX] = []
    for i in range(n):
        y.append(b[i] - sum(L[i][k] * y[k] for k in range(i)))
    x: list[ca.SX] = [ca.SX(0)] * n
    for i in reversed(range(n)):
        x[i] = y[i] * inverse[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))
    return ca.vertcat(*x)
