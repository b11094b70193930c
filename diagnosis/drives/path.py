"""From the commanded to the reported torque: what drives do before the joint feels anything.

    tau = tau_meas + sum_j gain_j column_j(tau)

The same search as for the mechanism, with a base model that is nothing but an offset; only
effects of the drive take part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Geometry, Known, Motion, Stated
from flexhex.diagnosis.kinds import Kinds, units_of
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.diagnosis.runs.smoothing import hann_weights
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]
OFFSET = 0.0125
"""Tolerance of the offset between command and report, relative to the torque's RMS."""


@dataclass(frozen=True)
class Driven(Motion):
    """Motion with the torques at its instants: command, reported (samples, n) [N m]."""

    command: Array
    reported: Array


class PathBase:
    """Drives that do as they are told; see `flexhex.diagnosis.basemodels.base.Base`."""

    curved: tuple[Known, ...] = ()
    widths: tuple[Known, ...] = ()
    geometry: Geometry | None = None
    late = 1e-3
    holds: frozenset[str] = frozenset()
    given: tuple[EffectUse, ...] = ()
    stated = Stated()
    payload: tuple[int, ...] = ()
    rotors: tuple[int, ...] = ()
    reach = np.inf
    complete = True

    def __init__(
        self, torque: Array, window: float, spacing: float, settle: float, kinds: Kinds = ()
    ) -> None:
        """torque (n,): RMS of each axis [N m, N]."""
        self.n, self.window, self.spacing, self.settle = len(torque), window, spacing, settle
        self.kinds = kinds
        gains = [Known(f"g[{i + 1}]", "1", 1.0, 1e-6, "g", i) for i in range(self.n)]
        units = units_of(self, self.n, "N m")
        offsets = [
            Known(f"o[{i + 1}]", unit, 0.0, max(OFFSET * float(rms), np.finfo(float).tiny), "o", i)
            for i, (unit, rms) in enumerate(zip(units, torque, strict=True))
        ]
        self.linear = (*gains, *offsets)

    def loaded(self, p: Array, payload: float) -> Array:
        """A payload changes nothing here."""
        return p

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed reported torque and ones, each for its own axis (rows, n, 2 n)."""
        assert isinstance(motion, Driven)
        smooth = weights @ motion.reported
        dense = np.zeros((weights.shape[0], self.n, 2 * self.n))
        each = np.arange(self.n)
        dense[:, each, each] = smooth
        dense[:, each, self.n + each] = 1.0
        return dense

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """No curved terms."""
        empty = np.zeros((len(motion.theta), 0))
        return empty, empty

    def torque(self, motion: Motion, p: Array) -> Array:
        """The command: columns of the effects are those of what was asked for."""
        assert isinstance(motion, Driven)
        return motion.command

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """Nothing acts on the mechanism."""
        return {}


def driven(runs: Sequence[Run], lag: float) -> list[Run]:
    """Runs whose torque is the command, `lag` [s] later; [] unless all runs have a command."""
    if any(run.command is None for run in runs):
        return []
    listed = [(run, run.command) for run in runs if run.command is not None]
    return [_driven(run, replace(command, t0=command.t0 + lag)) for run, command in listed]


def _driven(run: Run, command: TimeSeries) -> Run:
    """Both torques as means about the joints' instants: a command that is held has no instants
    of its own, and samples of it come half a hold too early."""
    m = run.motion
    (commanded, known), (reported, heard) = (_at(signal, m) for signal in (command, run.tau))
    motion = Driven(m.t0, m.ts, m.theta, m.thetad, m.thetadd, commanded, reported)
    valid = run.valid & known & heard
    return replace(run, motion=motion, valid=valid, tau=TimeSeries(m.t0, m.ts, commanded, valid))


def _at(signal: TimeSeries, motion: Motion) -> tuple[Array, NDArray[np.bool_]]:
    """Means (samples, n) about the instants of a motion, and where they are known.

    Straight lines elsewhere: a hole would be a jump in the rates of its neighbours.
    """
    window, clock = 2 * motion.ts, motion.time
    weights, filled = hann_weights(clock, signal.t0, signal.ts, signal.valid, window)
    if not filled.any():
        return np.zeros((len(clock), signal.values.shape[1])), filled
    known = weights[filled] @ signal.values
    values = [np.interp(clock, clock[filled], own) for own in known.T]
    return np.stack(values, axis=1), filled
