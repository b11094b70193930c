"""Errors of a machine's geometry as columns of the base model.

    tau(e) = tau(0) + sum_j e_j d tau / d e_j

e: places and angles of joints, lengths, each zero in the machine file. The derivatives are taken at
the fitted masses and inertias; what is left out is of the order of e squared. They are those of
the smoothed motion instead of smoothed themselves: less noise, a row instead of its samples, and an
error of up to 5 % where logs are slow, which is 1e-4 of the torque.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Known, Motion
from flexhex.numeric.rows import RowFunction, alike

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Derivatives:
    """known: the errors e, nominally zero; state: of a motion, arrays (samples, ...);
    pulled: from states, parameters and seed (samples, n) to seed^T d tau / d e (samples, n_e)."""

    known: tuple[Known, ...]
    state: Callable[[Motion], Sequence[Array]]
    pulled: RowFunction

    def columns(self, motion: Motion, weights: csr_array, p: Array) -> Array:
        """Derivatives (rows, n, n_e) of the torques at parameters p (n_p,); weights (rows, samples)
        of the smoothing. Zeros in rows that have no sample."""
        rows, n = np.flatnonzero(weights.sum(axis=1)), motion.theta.shape[1]
        state = [weights[rows] @ values for values in self.state(motion)]
        parameters = alike(p, len(rows))
        derivatives = np.zeros((weights.shape[0], n, len(self.known)))
        for i, seed in enumerate(np.eye(n)):
            (derivatives[rows, i],) = self.pulled(*state, parameters, alike(seed, len(rows)))
        return derivatives


def pulled(name: str, states: Sequence[ca.SX], p: ca.SX, e: ca.SX, tau: ca.SX) -> ca.Function:
    """Function (states, p, seed) -> seed^T d tau / d e at e = 0, by one sweep backwards."""
    seed = ca.SX.sym("seed", tau.numel())
    swept = ca.substitute(ca.jtimes(tau, e, seed, True), e, ca.SX.zeros(e.numel()))
    return ca.Function(name, [*states, p, seed], [ca.cse(ca.densify(swept))])
