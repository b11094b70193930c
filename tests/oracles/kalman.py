"""The parameter estimator as a textbook Kalman filter in Joseph form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracles.calculus import Array


@dataclass
class Kalman:
    """State q = p / s, random walk, covariance P (n, n) of q.

    p (n,): first parameters; s (n,): their scales, none zero; P0: start variance, one value
    or one per parameter; r1 (n,): drift variance of q per step; r2 [N2 m2]: variance of a
    torque; adapting (n,): others keep value, have no drift and no variance.
    """

    p: Array
    s: Array
    P0: float | Array
    r1: Array
    r2: float
    adapting: Array

    def __post_init__(self) -> None:
        self.q = self.p / self.s
        self.P = np.diag(np.broadcast_to(self.P0, self.q.shape) * self.adapting)

    def step(self, Phi: Array, tau: Array) -> tuple[Array, Array]:
        """Predict, then correct with tau (m,) = Phi (m, n) p + noise: p (n,) and P (n, n).

        P <- P + R1;  H = Phi diag(s);  G = P H^T (H P H^T + R2)^-1
        q <- q + G (tau - H q);  P <- (1 - G H) P (1 - G H)^T + G R2 G^T
        """
        self.P = self.P + np.diag(self.r1 * self.adapting)
        H = Phi * self.s
        R2 = self.r2 * np.eye(len(tau))
        S = H @ self.P @ H.T + R2
        gain = np.linalg.solve(S, H @ self.P).T
        self.q = self.q + gain @ (tau - H @ self.q)
        keep = np.eye(len(self.q)) - gain @ H
        self.P = keep @ self.P @ keep.T + gain @ R2 @ gain.T
        return self.q * self.s, self.P
