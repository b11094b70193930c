"""A log as rows of a fit: smoothed model columns and torque, and which rows may be used.

Long logs are worked through in parts, so that memory does not grow with them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Channel, Log
from flexhex.diagnosis.motion import Columns, MotionModel, dahl_states, differences, smooth
from flexhex.diagnosis.play import REACH, angle_noise, play
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.filter.equations import hann

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
PART = 20_000
"""Rows that are worked on at a time: 10 s at 2 kHz, about 150 MB."""


@dataclass(frozen=True)
class Motion:
    """Angles and torques of a log at the feedforward's rate, from `first` on.

    time (samples,) [s]; theta, tau (samples, n); z (samples, n) Dahl states; valid (samples,):
    measured, and not within `settle` of the start or of a break; ts [s]; first: sample at which
    rows begin.
    """

    time: Array
    theta: Array
    tau: Array
    z: Array
    valid: Mask
    ts: float
    first: int


@dataclass(frozen=True)
class Rows:
    """Smoothed columns and torque (rows, n) [N m] at the times (rows,) [s] of window centres.

    usable (rows,): nothing under the window was filled, clipped or before settling.
    """

    columns: Columns
    tau: Array
    time: Array
    usable: Mask


def motion(machine: Machine, log: Log, settle: float) -> Motion:
    """A log at the feedforward's rate. LogError when it does not fit the machine or is short."""
    checked(machine, log)
    long_enough(machine, log, settle)
    angle = log["theta"]
    stride = max(1, round(machine.timing.feedforward / angle.ts))
    torque, measured = on_clock(log["tau_meas"], angle)
    valid = angle.valid & measured
    ts = stride * angle.ts
    first, count = max(int(settle / ts), 1), -(-len(angle.values) // stride)
    # a sample between two strides counts: it may stand for a break
    starts = np.maximum(np.arange(count) * stride - stride + 1, 0)
    kept = np.logical_and.reduceat(valid, starts) if stride > 1 else valid.copy()
    for index, _ in angle.breaks:
        begin = index // stride
        kept[begin : begin + first] = False
    theta = angle.values[::stride]
    z = dahl_states(play(theta, REACH * angle_noise(theta)), machine.actuator.sigma)
    return Motion(angle.time[::stride], theta, torque[::stride], z, kept, ts, first)


def long_enough(machine: Machine, log: Log, settle: float) -> None:
    """LogError when hardly a window is left after settling."""
    seconds = len(log.theta) * log.ts
    needed = settle + 4 * machine.control.hann_points * machine.timing.feedforward
    if seconds < needed:
        raise LogError(
            f"{log.name}: {seconds:.3g} s are too short, at least {needed:.3g} s are needed"
        )


def on_clock(channel: Channel, clock: Channel) -> tuple[Array, Mask]:
    """Values (samples, width) of a channel at the instants of another, and which are measured.

    Cubic between the four neighbours, so that signals well below half the slower rate pass
    unchanged; samples at the same instants are handed on as they are.
    """
    same = (channel.t0, channel.ts, channel.breaks) == (clock.t0, clock.ts, clock.breaks)
    if same and len(channel.values) == len(clock.values):
        return channel.values, channel.valid
    known, wanted = channel.time, clock.time
    k = np.clip(np.searchsorted(known, wanted, side="right") - 1, 1, len(known) - 3)
    u = ((wanted - known[k]) / channel.ts)[:, None]
    a, b, c, d = (channel.values[k + j] for j in (-1, 0, 1, 2))
    values = (
        -a * u * (u - 1) * (u - 2) / 6
        + b * (u + 1) * (u - 1) * (u - 2) / 2
        - c * (u + 1) * u * (u - 2) / 2
        + d * (u + 1) * u * (u - 1) / 6
    )
    good = channel.valid
    four = good[k - 1] & good[k] & good[k + 1] & good[k + 2]
    inside = (wanted >= known[0]) & (wanted <= known[-1])
    return np.where(inside[:, None], values, 0.0), four & inside


def parts(model: MotionModel, log: Log, settle: float, part: int = PART) -> Iterator[Rows]:
    """Rows of one log, its first `settle` s left out, `part` rows at a time."""
    moved = motion(model.machine, log, settle)
    window = hann(model.machine.control.hann_points)
    effects = model.effects(moved.time, moved.theta, moved.tau)
    total = len(moved.theta) - moved.first - 1 - len(window) + 1
    for begin in range(0, total, part):
        yield _part(model, moved, effects, window, begin, min(begin + part, total))


def _part(
    model: MotionModel, moved: Motion, effects: Array, window: Array, begin: int, end: int
) -> Rows:
    points = len(window)
    low, high = moved.first + begin, moved.first + end + points - 1
    around, cut = slice(low - 1, high + 1), slice(low, high)
    rate, acceleration = differences(moved.theta[around], moved.ts)
    raw = model.columns(moved.theta[cut], moved.z[cut], rate, acceleration, effects[cut])
    bad = np.concatenate([[0], np.cumsum(~moved.valid[around])])
    # row k sees the samples k - 1 to k + points of this part, with the stencils
    usable = bad[points + 2 :] == bad[: -(points + 2)]
    middle = moved.time[low + (points - 1) // 2 :][: end - begin]
    columns = Columns(smooth(raw.values, window), raw.rows, raw.cols, raw.shape)
    return Rows(columns, smooth(moved.tau[cut], window), middle, usable)


def checked(machine: Machine, log: Log) -> None:
    """LogError when a log cannot be one of this machine's."""
    n, stroke = machine.n_arms, machine.geometry.stroke
    if log.theta.shape[1] != n:
        raise LogError(f"{log.name}: {log.theta.shape[1]} joints, {machine.name} has {n}")
    largest = float(np.abs(log.theta).max())
    if largest > stroke:
        raise LogError(
            f"{log.name}: an angle of {largest:.4g} rad is beyond the stroke of {stroke:.4g} rad:"
            " are these degrees, or counts?"
        )
    for name in ("theta", "tau_meas"):
        if log[name].ts > machine.timing.feedforward * (1 + 1e-3):
            raise LogError(
                f"{log.name}: a sample of {name} every {log[name].ts:.4g} s is too slow, at most"
                f" {machine.timing.feedforward:.4g} s: is `time` in seconds?"
            )
    turned = [finding for finding in log.findings if finding.kind in ("swapped", "sign")]
    if turned:
        raise LogError(f"{turned[0].where}: {turned[0].text}: name the channels as they are")
