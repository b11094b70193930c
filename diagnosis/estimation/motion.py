"""What a log says about the mechanism: angles to coordinates, rates and model columns.

Angles are exact to the encoder's step, so rates are plain central differences and every
model column is evaluated at the raw motion; only then are columns and torque smoothed by
one and the same window. Nothing nonlinear is ever evaluated at a filtered angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.closure import Closure, dahl_scan
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import columns_function, followers
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.filter.equations import derivatives
from flexhex.numeric.convolved import convolved
from flexhex.numeric.rows import native

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SparseRegressor:
    """Model columns along a log: values (samples, nonzeros) of Phi's structural nonzeros.

    rows, cols: where each nonzero stands in Phi (n, n_p). `shape` is Phi's.
    """

    values: Array
    rows: NDArray[np.int64]
    cols: NDArray[np.int64]
    shape: tuple[int, int]

    def stacked(self, every: int) -> Array:
        """Dense (samples / every * n, n_p), joint by joint within a sample."""
        picked = self.values[::every]
        dense = np.zeros((len(picked), *self.shape))
        dense[:, self.rows, self.cols] = picked
        return dense.reshape(-1, self.shape[1])


def smooth(signal: Array, window: Array, every: int = 1) -> Array:
    """Windowed signal (samples - points + 1, ...), every so many samples of it: only where the
    window is filled."""
    flat = signal.reshape(len(signal), -1)
    if every == 1:
        filtered = convolved(flat, window)
    else:
        begins = np.arange(0, len(flat) - len(window) + 1, every)
        under = (begins[:, None] + np.arange(len(window))).ravel()
        ends = len(window) * np.arange(len(begins) + 1)
        weights = csr_array(
            (np.tile(window[::-1], len(begins)), under, ends), (len(begins), len(flat))
        )
        filtered = weights @ flat
    return np.asarray(filtered.reshape(-1, *signal.shape[1:]))


def differences(theta: Array, ts: float) -> tuple[Array, Array]:
    """thetad, thetadd (samples - 2, n) by the stencils of [SH, IV-D] (second one with its sign)."""
    first, second = derivatives(theta[:-2], theta[1:-1], theta[2:], ts)
    return first, second


Derive = Callable[[Array, float], tuple[Array, Array]]
"""Stencils as `differences`: angles and their sample time to both rates."""


def dahl_states(theta: Array, sigma: float) -> Array:
    """z (samples, n) along the angles, from zero, exact for steps of one sign.  [SH, Eq. (23)]"""
    n = theta.shape[1]
    return dahl_scan(n)(np.zeros(n), theta, np.full(n, sigma))


class MotionModel:
    """Vectorised model functions for the samples of a log."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.model = machine, Model(machine)
        model, n = self.model, self.model.n
        x, xd, xdd = (ca.SX.sym(name, model.n_x) for name in ("x", "xd", "xdd"))
        z = ca.SX.sym("z", n)
        effects = ca.SX.sym("effects", model.bank.n_gains)
        Phi = model.regressor(x, xd, xdd, ca.vertcat(model.basis(x[:n], z), effects))
        sparsity = Phi.sparsity()
        self._rows, self._cols = np.array(sparsity.row()), np.array(sparsity.get_col())
        self._shape = (n, model.n_p)
        entries: Any = Phi.nonzeros()
        values = ca.vertcat(*entries)
        phi = ca.Function("native_phi", [x, xd, xdd, z, effects], ca.cse([values]))
        (self._phi,) = native([phi])
        self._closure = Closure(model)

    def close(self, theta: Array) -> Array:
        """x~ (samples, 37) for angles (samples, n)."""
        return self._closure.solve(theta)

    def rates(self, x: Array, thetad: Array, thetadd: Array) -> tuple[Array, Array]:
        """xd, xdd (samples, 37)."""
        return self._closure.rates(x, thetad, thetadd)

    def effects(self, time: Array, theta: Array, tau: Array, derive: Derive = differences) -> Array:
        """Columns of the machine's effects at raw samples (samples, n_gains), from rest.

        time (samples,) [s]; theta, tau (samples, n); derive: the stencils. The first and the last
        sample repeat their neighbour's columns, since rates are central differences.
        """
        bank, ts = self.model.bank, float(time[1] - time[0])
        if not bank:
            return np.zeros((len(theta), 0))
        rate, acceleration = derive(theta, ts)
        middle, inner = tau[1:-1], time[1:-1, None]
        at = np.hstack([theta[1:-1], rate, acceleration, middle, derive(tau, ts)[0], inner])
        start, advance = followers(bank, "along")
        state = ca.DM(start(theta[1]))
        if any(part.effect.states for part in bank.parts):
            pair, kept = ca.SX.sym("pair", 2 * at.shape[1]), ca.SX.sym("state", bank.n_states)
            then = advance(*ca.vertsplit(pair, at.shape[1]), kept, ts)
            step = ca.Function("step", [kept, pair], [then])
            followed = step.mapaccum(len(at) - 1)(state, np.hstack([at[:-1], at[1:]]).T)
            states = np.vstack([np.array(state).T, np.array(followed).T])
        else:
            states = np.zeros((len(at), bank.n_states))
        (columns,) = native([columns_function(bank, "native_effects")])
        (values,) = columns(at, states)
        return np.vstack([values[:1], values, values[-1:]])

    def columns(
        self,
        theta: Array,
        z: Array,
        thetad: Array,
        thetadd: Array,
        effects: Array | None = None,
    ) -> SparseRegressor:
        """Model columns at every sample; all arguments (samples, n).

        effects (samples, n_gains): columns of the machine's effects there, none of them acts
        where they are not given.
        """
        if effects is None:
            effects = np.zeros((len(theta), self.model.bank.n_gains))
        x = self.close(theta)
        xd, xdd = self.rates(x, thetad, thetadd)
        (values,) = self._phi(x, xd, xdd, z, effects)
        return SparseRegressor(values, self._rows, self._cols, self._shape)


@lru_cache(maxsize=4)
def motion_model(machine: Machine) -> MotionModel:
    """The model functions of a machine, kept: CasADi needs most of a second for them."""
    with SYMBOLIC:
        return MotionModel(machine)
