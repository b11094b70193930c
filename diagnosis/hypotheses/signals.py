"""What effects follow along the runs: motion, torques, time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.reversals import angle_noise
from flexhex.diagnosis.runs.smoothing import hann_weights
from flexhex.fmus.filter.equations import hann
from flexhex.numeric.convolved import convolved

Array = NDArray[np.float64]
LOUD = 0.05
"""Noise of the fit's torque, relative to its RMS, from which it is smoothed."""
SLOW = 2e-3
"""Errors of an angle are evaluated this often [s]."""


def signals_of(model: Calibrated, across: bool, torques: bool) -> list[Array]:
    """Angle, rate, acceleration, torque, its rate, time: of all axes (samples, n, 6), of each
    block. across: time goes on from run to run. torques: that which the drive reports by the base
    model and its rate are wanted, which take longest to make; else they are zero."""
    signals = []
    for k, block in enumerate(model.blocks):
        motion = block.run.motion
        clock = motion.time - motion.t0 + (block.run.start if across else 0.0)
        time = np.broadcast_to(clock[:, None], motion.theta.shape)
        torque = _based(model, k) if torques else np.zeros((*motion.theta.shape, 2))
        listed = (motion.theta, motion.thetad, motion.thetadd, *np.moveaxis(torque, 2, 0), time)
        signals.append(np.stack(listed, axis=2))
    return signals


def _based(model: Calibrated, k: int, found: Array | float = 0.0) -> Array:
    """Torques that the drives report by the base model and effects that were found (samples, n),
    and their rates (samples, n, 2), of a block."""
    motion = model.blocks[k].run.motion
    torque = (_quiet(model, model.raw[k], motion.ts) + found) / (1.0 - model.fitted.losses)
    return np.stack([torque, np.gradient(torque, motion.ts, axis=0)], axis=2)


def reported(model: Calibrated, found: Sequence[Array]) -> list[Array]:
    """Torques that the drives report by the fit, with those of effects that were found
    (samples, n), and their rates (samples, n, 2), of each block."""
    return [_based(model, k, own) for k, own in enumerate(found)]


def entering(model: Calibrated) -> list[Array]:
    """Torques that the drives report, and their rates, at the instants of the angles
    (samples, n, 2), of each block."""
    reported = []
    for block in model.blocks:
        tau, motion = block.run.tau, block.run.motion
        clock = tau.t0 + tau.ts * np.arange(len(tau.values))
        at, known = motion.time + model.fitted.delay, tau.valid
        own = [np.interp(at, clock[known], v[known]) for v in tau.values.T]
        torque = np.stack(own, axis=1)
        reported.append(np.stack([torque, np.gradient(torque, motion.ts, axis=0)], axis=2))
    return reported


def late(model: Calibrated, line: str) -> list[Array]:
    """Torques that drives with the lag or delay of the fit pass on, and how much more they report,
    divided by that time (samples, n, 2), of each block."""
    behind, lag = list[Array](), model.fitted.lag
    for block, reported in zip(model.blocks, entering(model), strict=True):
        torque = reported[:, :, 0]
        joint = let_through(torque, line, lag, block.run.motion.ts)
        behind.append(np.stack([joint, (torque - joint) / lag], axis=2))
    return behind


def let_through(torque: Array, line: str, time: float, ts: float) -> Array:
    """What a drive with a first-order lag, or with a delay, of some time [s] makes of torques
    (samples, n) every ts [s], with straight lines between them."""
    if line == "delay":
        at = ts * np.arange(len(torque))
        return np.stack([np.interp(at - time, at, own) for own in torque.T], axis=1)
    from scipy.signal import lfilter, lfilter_zi  # takes long to load

    kept = np.exp(-ts / time)
    mean = (1 - kept) * time / ts
    filters = [1 - mean, mean - kept], [1, -kept]
    begun = lfilter_zi(*filters)[:, None] * torque[:1]
    return np.asarray(lfilter(*filters, torque, axis=0, zi=begun)[0])


def passed_on(model: Calibrated, found: Sequence[Array]) -> list[Array]:
    """Reported torques less those of the rotors and of effects that were found, and their rates
    (samples, n, 2), of each block: what springs behind the rotors feel, in whichever way these let
    the links swing."""
    places, remaining = list(model.base.rotors), list[Array]()
    for block, own, less in zip(model.blocks, entering(model), found, strict=True):
        motion = block.run.motion
        torque = own[:, :, 0] - model.linear(block.run)[places] * motion.thetadd - less
        remaining.append(np.stack([torque, np.gradient(torque, motion.ts, axis=0)], axis=2))
    return remaining


def flat(signals: Array, length: float, ts: float) -> Array:
    """Signals (samples, k), one every ts [s], smoothed over a length [s] by a Hann window, and what
    that takes away smoothed likewise and added (twicing, Tukey 1977): slow waves keep their size.
    """
    once = hann(2 * max(round(length / ts / 2), 1))[1:]  # the first one is zero
    taps = 2.0 * np.pad(once, len(once) // 2) - np.convolve(once, once)
    reach = len(taps) // 2
    return convolved(np.pad(signals, ((reach, reach), (0, 0)), mode="edge"), taps)


def averaged(model: Calibrated) -> list[Motion]:
    """The mean motion under the window of each row, of each block."""
    motions = []
    for block in model.blocks:
        motion = block.run.motion
        own = [block.smooth(v) for v in (motion.theta, motion.thetad, motion.thetadd)]
        motions.append(Motion(float(block.at[0] + block.run.shift), model.spacing, *own))
    return motions


def slow_weights(model: Calibrated) -> list[tuple[int, csr_array]]:
    """Of each block how many samples make a step of about `SLOW`, and the weights (m, steps) of
    every such sample."""
    weights = []
    for block in model.blocks:
        motion = block.run.motion
        step = max(1, round(SLOW / motion.ts))
        valid = np.ones(len(motion.theta[::step]), dtype=bool)
        at = block.at + block.run.shift
        own, _ = hann_weights(at, motion.t0, step * motion.ts, valid, model.base.window)
        weights.append((step, own))
    return weights


def _quiet(model: Calibrated, tau: Array, ts: float) -> Array:
    """Torque of the fit (samples, n) [N m], smoothed on axes where noise of the accelerations is a
    good part of it: what gives way at high torque would give way to that."""
    points = 2 * round(model.base.window / ts / 2)
    loud = angle_noise(tau) > LOUD * model.torque_rms
    if points < 4 or not loud.any():
        return tau
    return np.where(loud, convolve1d(tau, hann(points), axis=0, mode="nearest"), tau)
