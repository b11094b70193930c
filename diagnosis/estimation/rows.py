"""A log as rows of a fit: smoothed model columns and torque, and which rows may be used.

A log faster than the feedforward is thinned to the feedforward's rate; a slower one keeps its
own. The window is equally long in seconds at every rate. Long logs are worked through in parts, so
that memory does not grow with them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.motion import (
    MotionModel,
    SparseRegressor,
    dahl_states,
    differences,
    smooth,
)
from flexhex.diagnosis.kinds import kinds_of, refuse_others
from flexhex.diagnosis.logs import Channel, Log
from flexhex.diagnosis.reversals import angle_noise, hysteresis_filter
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.filter.equations import hann

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
PART = 20_000
"""Rows that are worked on at a time: 10 s at 2 kHz, about 150 MB."""
SAME = 1 + 1e-3
"""Sample times within this ratio count as equal."""
FEWEST_TAPS = 3
"""Least samples within the window; of 50 ms it admits logs from 60 Hz on."""
EDGE = 2
"""Samples at each end of a slow log whose rates are less exact."""


@dataclass(frozen=True)
class ResampledLog:
    """Angles and torques of a log at the feedforward's rate or its own, from `first` on.

    time (samples,) [s]; theta, thetad, thetadd, tau (samples, n); z (samples, n) Dahl states; valid
    (samples,): measured, and not within `settle` of the start or of a break; ts [s]; first: sample
    at which rows begin. The first and the last sample repeat their neighbour's rates.
    """

    time: Array
    theta: Array
    thetad: Array
    thetadd: Array
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

    columns: SparseRegressor
    tau: Array
    time: Array
    usable: Mask


def motion(machine: Machine, log: Log, settle: float) -> ResampledLog:
    """A log at the feedforward's rate, or its own where that is slower. LogError when it does not
    fit the machine or is short."""
    checked(machine, log)
    long_enough(machine, log, settle)
    clock = slower(log)
    ts = row_step(machine, log)
    stride = round(ts / clock.ts)
    angle, seen = on_clock(log["theta"], clock)
    torque, measured = on_clock(log["tau_meas"], clock)
    valid = seen & measured
    first, count = max(int(settle / ts), 1), -(-len(angle) // stride)
    # a sample between two strides counts: it may stand for a break
    starts = np.maximum(np.arange(count) * stride - stride + 1, 0)
    kept: Mask = np.logical_and.reduceat(valid, starts) if stride > 1 else valid.copy()
    for index, _ in clock.breaks:
        begin = index // stride
        kept[begin : begin + first] = False
    theta = angle[::stride]
    if slow(machine, ts):
        reach = np.pad(kept, EDGE)
        around = np.lib.stride_tricks.sliding_window_view(reach, 2 * EDGE + 1)
        kept = np.asarray(around.all(axis=1))
    z = dahl_states(hysteresis_filter(theta, angle_noise(theta)), machine.actuator.sigma)
    inner = rates(machine, theta, ts)
    thetad, thetadd = (np.concatenate([v[:1], v, v[-1:]]) for v in inner)
    return ResampledLog(
        clock.time[::stride], theta, thetad, thetadd, torque[::stride], z, kept, ts, first
    )


def slower(log: Log) -> Channel:
    """The channel whose instants the rows have: the angles, or slower torques."""
    angle, torque = log["theta"], log["tau_meas"]
    return torque if torque.ts > SAME * angle.ts else angle


def row_step(machine: Machine, log: Log) -> float:
    """Time between rows [s]: the feedforward's sample time, or the log's where that is longer."""
    ts = slower(log).ts
    return max(1, round(machine.timing.feedforward / ts)) * ts


def slow(machine: Machine, ts: float) -> bool:
    """Whether samples every ts [s] are fewer than the feedforward's."""
    return ts > SAME * machine.timing.feedforward


def window_length(machine: Machine) -> float:
    """Length of the filter's window [s]."""
    return machine.control.hann_points * machine.timing.feedforward


def window_of(machine: Machine, ts: float) -> Array:
    """The filter's Hann window for samples every ts [s]: equally long in seconds at every rate."""
    return hann(round(window_length(machine) / ts))


def rates(machine: Machine, theta: Array, ts: float) -> tuple[Array, Array]:
    """thetad, thetadd (samples - 2, n) [rad/s, rad/s2] of angles (samples, n) every ts [s].

    The stencils of [SH, IV-D] at the feedforward's rate. Their errors, (w ts)^2/6 and
    (w ts)^2/12 at the frequency w, are those of central differences: at 10 Hz and 250 Hz sampling
    1 % and 0.5 %. Slower logs get the central stencils of sixth order over seven samples, with
    errors (w ts)^6/140 and (w ts)^6/560 [Fornberg, Math. Comp. 51 (1988) 699]; EDGE samples at
    each end keep second order.
    """
    first, second = differences(theta, ts)
    if not slow(machine, ts) or len(theta) < 2 * EDGE + 3:
        return first, second
    count = len(theta) - 6
    near, middle, far = (theta[3 + k :][:count] - theta[3 - k :][:count] for k in (1, 2, 3))
    first[EDGE:-EDGE] = (45 * near - 9 * middle + far) / (60 * ts)
    near, middle, far = (theta[3 + k :][:count] + theta[3 - k :][:count] for k in (1, 2, 3))
    second[EDGE:-EDGE] = (270 * near - 27 * middle + 2 * far - 490 * theta[3:-3]) / (180 * ts**2)
    return first, second


def long_enough(machine: Machine, log: Log, settle: float) -> None:
    """LogError when hardly a window is left after settling."""
    seconds = len(log.theta) * log.ts
    needed = settle + 4 * window_length(machine)
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


def parts(
    model: MotionModel, log: Log, settle: float, part: int = PART, every: int = 1
) -> Iterator[Rows]:
    """Rows of one log, its first `settle` s left out, from `part` samples at a time; of these one
    row each `every` samples."""
    moved = motion(model.machine, log, settle)
    window = window_of(model.machine, moved.ts)
    derive = partial(rates, model.machine)
    effects = model.effects(moved.time, moved.theta, moved.tau, derive)
    total = len(moved.theta) - moved.first - 1 - len(window) + 1
    for begin in range(0, total, part):
        yield _part(model, moved, effects, window, range(begin, min(begin + part, total), every))


def _part(
    model: MotionModel, moved: ResampledLog, effects: Array, window: Array, wanted: range
) -> Rows:
    points, every = len(window), wanted.step
    low, high = moved.first + wanted.start, moved.first + wanted.stop + points - 1
    around, cut = slice(low - 1, high + 1), slice(low, high)
    rate, acceleration = moved.thetad[cut], moved.thetadd[cut]
    raw = model.columns(moved.theta[cut], moved.z[cut], rate, acceleration, effects[cut])
    bad = np.concatenate([[0], np.cumsum(~moved.valid[around])])
    # row k sees the samples k - 1 to k + points of this part, with the stencils
    usable = bad[points + 2 :] == bad[: -(points + 2)]
    middle = moved.time[low + (points - 1) // 2 :][: len(usable)]
    columns = SparseRegressor(smooth(raw.values, window, every), raw.rows, raw.cols, raw.shape)
    tau = smooth(moved.tau[cut], window, every)
    return Rows(columns, tau, middle[::every], usable[::every])


def checked(machine: Machine, log: Log) -> None:
    """LogError when a log cannot be one of this machine's."""
    refuse_others(log.name, log.kinds, kinds_of(machine, machine.n_arms), machine.name)
    n, stroke = machine.n_arms, machine.geometry.stroke
    if log.theta.shape[1] != n:
        width = log.theta.shape[1]
        raise LogError(
            f"{log.name}: {width} {'axis' if width == 1 else 'axes'}, {machine.name} has {n}: give"
            " the machine file of this log, or fit single axes with `flexhex diagnose --base axis`"
        )
    largest = float(np.abs(log.theta).max())
    if largest > stroke:
        raise LogError(
            f"{log.name}: an angle of {largest:.4g} rad is beyond the stroke of {stroke:.4g} rad:"
            " are these degrees, or counts?"
        )
    slowest, ts = window_length(machine) / FEWEST_TAPS, slower(log).ts
    if ts > SAME * slowest:
        raise LogError(
            f"{log.name}: {1 / ts:.4g} samples per second, at least {np.ceil(1 / slowest):.0f} are"
            f" needed: the filter's window of {1e3 * window_length(machine):.3g} ms must hold"
            f" {FEWEST_TAPS} of them; log faster, or, where `time` is in ms, say so:"
            " --unit 'time=ms not s'"
        )
    turned = [finding for finding in log.findings if finding.kind in ("swapped", "sign")]
    if turned:
        raise LogError(f"{turned[0].where}: {turned[0].text}: name the channels as they are")
