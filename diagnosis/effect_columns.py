"""Columns of a machine's own effects along a log, for the fit of p.

Torques of drives and their rates come from the model, not from the log: its noise would make the
columns depend on what they are to explain.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from fmugen.native import native
from fmugen.scan import scans
from numpy.typing import NDArray

from fmus.common.effect_bank import SIGNALS, Bank, columns_function, instant
from fmus.common.machine import Machine

Array = NDArray[np.float64]


class EffectColumns:
    """The effects of a machine that belong to p, compiled for samples of a log."""

    def __init__(self, machine: Machine) -> None:
        self.bank = bank = Bank.known(machine)
        n, width = bank.n, len(SIGNALS) * bank.n + 1
        (self._columns,) = native([columns_function(bank, "native_effect_columns")])
        before, now = ca.SX.sym("before", width), ca.SX.sym("now", width)
        state, Ts = ca.SX.sym("state", bank.n_states), ca.SX.sym("Ts")
        following = bank.advance(instant(before, n), instant(now, n), state, Ts)
        made = ca.Function("scan_effects", [state, before, now, Ts], [ca.cse(following)])
        (self._along,) = scans([made])

    def along(self, theta: Array, thetad: Array, thetadd: Array, tau: Array, ts: float) -> Array:
        """Columns (samples, n_gains) for a motion and torque (samples, n) every ts [s]."""
        taud = np.gradient(tau, ts, axis=0)
        time = ts * np.arange(len(theta))[:, None]
        inputs = np.hstack([theta, thetad, thetadd, tau, taud, time])
        start = np.array(ca.DM(ca.evalf(self.bank.start(ca.SX(theta[0].tolist()))))).ravel()
        states = self._along(start, inputs, np.array([ts]))
        (columns,) = self._columns(inputs, states)
        return np.asarray(columns)
