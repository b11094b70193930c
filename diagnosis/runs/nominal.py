"""What the torque that a base model's file says of a motion leaves of the measured one, beside
friction and a rotor on each axis that cannot be negative."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Motion, Standing
from flexhex.diagnosis.runs.arrangements import Seen

Array = NDArray[np.float64]
NEARLY = 2.0
"""Factor by which the nominal torque may be wrong."""
SURE = 3.0
"""Standard deviations from which runs contradict a value."""
SHARP = (0.005, 0.05, 0.5)
"""Rates, relative to their RMS, at which dry friction is there: a sum of these is friction that
grows from rest in any way."""


def scaled(base: Base, seen: Sequence[Seen], axis: int) -> tuple[Array, Array, Array]:
    """See `beside_friction`, of the nominal torque."""
    return beside_friction(seen, nominal_torque(base, seen)[:, axis], axis)


def left_of(base: Base, seen: Sequence[Seen], without: bool = False, offset: bool = True) -> Array:
    """Share (n,) of each axis' mean square that nominal torque, friction and rotor leave, and an
    offset; without: those that these leave alone."""
    model = np.zeros((sum(len(s.tau) for s in seen), base.n))
    if not without:
        model = nominal_torque(base, seen)
    shares = np.zeros(base.n)
    for i in range(base.n):
        columns = beside_friction(seen, model[:, i], i, offset)
        shares[i] = _least(*columns) / len(model)
    return shares


def _least(nominal: Array, others: Array, tau: Array) -> float:
    """Sum of squares that is left at best of tau (samples,) by the nominal torque (samples,) times
    1 / NEARLY to NEARLY and by others (samples, k), none below zero."""
    # beside its least share nothing is below zero
    rest = tau - nominal / NEARLY
    x, norm = not_below_zero(np.column_stack([nominal, others]), rest)
    if x[0] > NEARLY - 1 / NEARLY:
        norm = not_below_zero(others, tau - NEARLY * nominal)[1]
    return float(norm**2)


def not_below_zero(columns: Array, tau: Array) -> tuple[Array, float]:
    """Coefficients (k,), none negative, and the norm of what they leave."""
    from scipy.optimize import nnls  # takes long to load

    x, norm = nnls(columns, tau)
    return x, float(norm)


def beside_friction(
    seen: Sequence[Seen], model: Array, axis: int, offset: bool = True
) -> tuple[Array, Array, Array]:
    """Nominal torque (samples,) of an axis, friction and rotor (samples, k) with an offset, and its
    measured torque (samples,), all relative to the deviation of the latter. Without an offset:
    relative to its RMS, with friction of either way for itself."""
    rate, acceleration, tau = (
        np.concatenate([getattr(s, name)[:, axis] for s in seen])
        for name in ("thetad", "thetadd", "tau")
    )
    speed = rate / max(_rms(rate), 1e-300)
    dry = [np.tanh(speed / sharp) for sharp in SHARP]
    if offset:
        ways = [*dry, np.ones(len(speed)), -np.ones(len(speed))]
    else:
        ways = [way for d in dry for way in ((d + 1) / 2, (d - 1) / 2)]
    others = np.stack([*ways, speed, acceleration / max(_rms(acceleration), 1e-300)], axis=1)
    unit = max(float(tau.std()) if offset else _rms(tau), 1e-300)
    return model / unit, others, tau / unit


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _nominal(base: Base) -> Array:
    """Parameters of the base model as they are written (n_p,), without rotors, which are fitted: in
    many files they are there for a simulator's sake."""
    nominal = np.array([known.nominal for known in base.linear])
    nominal[list(base.rotors)] = 0.0
    return nominal


def nominal_torque(base: Base, seen: Sequence[Seen]) -> Array:
    """Torques (samples, n) of the parameters as they are written, with announced payloads."""
    torques = list[Array]()
    for s in seen:
        torque = base.torque(_motion(s), base.loaded(_nominal(base), s.payload))
        if s.gravity is not None and isinstance(base, Standing):
            torque = torque + weights_of(base, s) @ (s.gravity - base.gravity)
        torques.append(torque)
    return np.concatenate(torques)


def weights_of(base: Base, seen: Seen) -> Array:
    """Torques (samples, n, 3) of the same for gravity of 1 m/s2 along each axis of the foot; zeros
    of a base model that does not know its own."""
    if not isinstance(base, Standing):
        return np.zeros((*seen.tau.shape, 3))
    return base.weights(_motion(seen), base.loaded(_nominal(base), seen.payload))


def _motion(seen: Seen) -> Motion:
    return Motion(0.0, 1.0, seen.theta, seen.thetad, seen.thetadd)
