"""Small linear solves as straight-line expressions, without pivoting.

Orthogonalisation needs no pivots, so one sequence of operations serves every pose: the
generated C has no branch and takes the same time at every step.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class RowFactor:
    """A = L Q, rows of Q orthonormal, L lower triangular; for a regular A (n, n).

    solve(b): A x = b;  solve_transposed(b): A^T x = b.
    """

    L: list[list[ca.SX]]
    Q: list[ca.SX]
    inverse_pivots: list[ca.SX]

    @staticmethod
    def of(A: ca.SX) -> RowFactor:
        """Modified Gram-Schmidt on the rows of A."""
        n = A.shape[0]
        rows = [A[i, :].T for i in range(n)]
        L: list[list[ca.SX]] = [[ca.SX(0)] * n for _ in range(n)]
        Q: list[ca.SX] = []
        inverse_pivots: list[ca.SX] = []
        for i in range(n):
            row = rows[i]
            for j in range(i):
                L[i][j] = ca.dot(row, Q[j])
                row = row - L[i][j] * Q[j]
            inverse = 1 / ca.sqrt(ca.dot(row, row))
            inverse_pivots.append(inverse)
            Q.append(row * inverse)
        return RowFactor(L, Q, inverse_pivots)

    def solve(self, b: ca.SX) -> ca.SX:
        """x (n,) of A x = b: forward substitution, then x = Q^T y."""
        y: list[ca.SX] = []
        for i, pivot in enumerate(self.inverse_pivots):
            y.append((b[i] - sum(self.L[i][j] * y[j] for j in range(i))) * pivot)
        return sum((self.Q[i] * y[i] for i in range(1, len(y))), self.Q[0] * y[0])

    def solve_transposed(self, b: ca.SX) -> ca.SX:
        """x (n,) of A^T x = b: y = Q b, then backward substitution."""
        n = len(self.Q)
        x: list[ca.SX] = [ca.SX(0)] * n
        for i in reversed(range(n)):
            y = ca.dot(self.Q[i], b)
            x[i] = (y - sum(self.L[j][i] * x[j] for j in range(i + 1, n))) * self.inverse_pivots[i]
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
        inverse.append(1 / (M[i, i] - sum(scaled[i][k] * L[i][k] for k in range(i))))
    y: list[ca.SX] = []
    for i in range(n):
        y.append(b[i] - sum(L[i][k] * y[k] for k in range(i)))
    x: list[ca.SX] = [ca.SX(0)] * n
    for i in reversed(range(n)):
        x[i] = y[i] * inverse[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))
    return ca.vertcat(*x)
