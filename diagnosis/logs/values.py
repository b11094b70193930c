"""What is wrong with the values themselves: NaN, constant, clipped, swapped, out of range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.kinds import LINEAR, ROTARY, Kinds
from flexhex.diagnosis.logs.log import Array, Channel, Finding, Mask
from flexhex.fmus.common.errors import LogError

NEEDED = ("theta", "tau_meas")
PLATEAU = 16
"""Samples at the extreme value that make a plateau."""
BEYOND = 8
"""Steps by which the way into a plateau would have gone on beyond it. The rounded top of a parabola
gives four; of 400 rounded sums of waves 9 % show more than four, none more than five."""
JUMP, MOST_JUMPS = 10.0, 1e-3
"""A step of the angle that is so many times the 99.9 % quantile is a jump; more of them than this
share of the samples are something else."""
ALONE, MOST_SPIKES = 0.99, 1e-2
"""A torque that differs by `JUMP` times this quantile of its steps from both its neighbours, to the
same side, is a spike; more of them than this share of the samples are something else."""
GROW = 1
"""Samples beside a plateau that are not trusted either: their filters saw it."""
FINEST = 1e-6
"""Smallest step of a torque that counts, relative to its range."""
FOLLOWS, STRANGER = 0.1, 0.3
"""Relative difference below which an angle follows a reference, and above which it does not."""
LARGEST = {
    ROTARY: {"theta": 20.0, "r": 20.0, "tau_meas": 1e4},
    LINEAR: {"theta": 100.0, "r": 100.0, "tau_meas": 1e5},
}
"""Beyond these [rad], [N m]; [m], [N] the unit is in doubt."""
SHORT = 1.0


def filled(where: str, name: str, channel: Channel) -> tuple[Channel, list[Finding]]:
    """Straight lines through gaps and NaN stretches; the latter become invalid and a finding."""
    values, valid = channel.values, channel.valid
    bad = ~np.isfinite(values).all(axis=1)
    if not bad.any():
        return channel, []
    good = ~bad
    measured = bad & valid
    if not good.any():
        if name in NEEDED:
            raise LogError(f"{where}: {name} holds no sample in which all axes are numbers")
        return channel, [Finding("nan", where, f"{name} holds no numbers: not used", False)]
    at, known = np.flatnonzero(bad), np.flatnonzero(good)
    values = values if values.flags.writeable else values.copy()
    for axis in range(values.shape[1]):
        values[at, axis] = np.interp(at, known, values[known, axis])
    findings = []
    if measured.any():
        stretches = int((np.diff(measured.astype(np.int8), prepend=0) == 1).sum())
        first = channel.t0 + channel.ts * int(np.argmax(measured))
        text = (
            f"{name} is not a number in {measured.sum()} samples ({stretches} stretches, the"
            f" first at {first:.6g} s): bridged by straight lines, not used"
        )
        findings.append(Finding("nan", where, text, True))
    return replace(channel, values=values, valid=valid & good), findings


def clipped(where: str, name: str, channel: Channel) -> tuple[Channel, list[Finding]]:
    """Samples at a torque limit become invalid: the torque there is not what was asked."""
    valid, findings = channel.valid, []
    for axis, column in enumerate(channel.values.T):
        at = plateaus(column, channel.valid)
        if at.any():
            limit = float(column[np.argmax(at)])
            grown = np.convolve(at, np.ones(2 * GROW + 1), mode="same") > 0
            valid = valid & ~grown
            text = f"{name}[{axis + 1}] is clipped at {limit:.4g} in {at.sum()} samples: not used"
            findings.append(Finding("clipped", where, text, True))
    return replace(channel, valid=valid), findings


def jumps(where: str, name: str, channel: Channel) -> tuple[Channel, list[Finding]]:
    """Angles that jump farther than any motion goes in a sample: samples that were lost without
    a gap in time, or a slip of the encoder. The samples beside a jump become invalid, and those
    before it that stand at the same value to the last digit, as readings do that froze."""
    valid, count, still, first = channel.valid, 0, 0, len(channel.values)
    for column in channel.values.T:
        moved = np.abs(np.diff(column))
        both = channel.valid[1:] & channel.valid[:-1]
        usual = moved[::7][both[::7]]
        if not len(usual):
            continue
        limit = JUMP * float(np.quantile(usual, 0.999))
        at = np.flatnonzero((moved > limit) & both) if limit > 0 else np.empty(0, dtype=int)
        if 0 < len(at) <= MOST_JUMPS * len(column):
            valid = valid.copy()
            valid[at] = valid[at + 1] = False
            moving = np.append(-1, np.flatnonzero(moved > 0))
            for jump, last in zip(at, np.searchsorted(moving, at) - 1, strict=True):
                begin = int(moving[last]) + 1
                valid[begin:jump] = False
                still += int(jump) + 1 - begin if begin < jump else 0
            count, first = count + len(at), min(first, int(at[0]))
    if not count:
        return channel, []
    when = channel.t0 + channel.ts * first
    text = f"{name} jumps {count} times, first at {when:.6g} s: samples lost, or an encoder slip"
    if still:
        text += f"; it stands still for {channel.ts * still:.3g} s before: frozen, not used"
    return replace(channel, valid=valid), [Finding("jump", where, text, True)]


def spikes(where: str, name: str, channel: Channel) -> tuple[Channel, list[Finding]]:
    """Torques of a single sample far off both its neighbours become invalid: no drive does that, a
    damaged word does."""
    valid, findings = channel.valid, []
    for axis, column in enumerate(channel.values.T):
        steps = np.where(channel.valid[1:] & channel.valid[:-1], np.diff(column), 0.0)
        limit = JUMP * float(np.quantile(np.abs(steps[::7]), ALONE))
        large = np.abs(steps) > limit
        first = np.flatnonzero(large[:-1] & large[1:])
        at = 1 + first[steps[first] * steps[first + 1] < 0]
        if limit > 0 and 0 < len(at) <= MOST_SPIKES * len(column):
            valid = valid.copy()
            valid[at] = False
            when = channel.t0 + channel.ts * int(at[0])
            spikes = f"{len(at)} spike{'s' * (len(at) > 1)} of a single sample"
            text = f"{name}[{axis + 1}] has {spikes}, first at {when:.6g} s"
            findings.append(Finding("spike", where, f"{text}: not used", True))
    return replace(channel, valid=valid), findings


def plateaus(column: Array, valid: Mask) -> Mask:
    """Samples (samples,) that stand at the largest or smallest value after a steep way there.

    A peak of a quantised signal also repeats its extreme value, but then the slope at its edge
    carries it over the plateau by a step or two only.
    """
    standing = np.zeros(len(column), dtype=bool)
    if not valid.any():
        return standing
    for extreme in (column[valid].max(), column[valid].min()):
        at = (column == extreme) & valid
        if at.sum() < PLATEAU or at.all():
            continue
        edge = np.diff(at.astype(np.int8), prepend=0, append=0)
        begin, end = np.flatnonzero(edge == 1), np.flatnonzero(edge == -1)
        moved = np.abs(np.diff(column))
        step = max(float(moved[moved > 0].min()), FINEST * float(np.ptp(column)))
        for a, b in zip(begin, end, strict=True):
            inside = a > 0 and b < len(column)  # at the ends of a run it is rest
            if inside and b - a >= PLATEAU and _steep(column, int(a), int(b), step):
                standing[a:b] = True
    if standing.any():
        # the shorter stays at a limit that is one
        for extreme in np.unique(column[standing]):
            standing |= (column == extreme) & valid
    return standing


def _steep(column: Array, a: int, b: int, step: float) -> bool:
    """Whether the way into or out of column[a:b] would have gone on beyond its value."""
    length = min(b - a, 50)
    into = abs(column[a] - column[a - length]) / length if a >= length else 0.0
    out = abs(column[b + length - 1] - column[b - 1]) / length if b + length <= len(column) else 0.0
    near = max(
        abs(column[a] - column[a - 1]) if a else 0.0,
        abs(column[b] - column[b - 1]) if b < len(column) else 0.0,
    )
    # what is flat for long after a slow approach is rest, not a limit
    return bool(min(max(into, out), near * 2) * length / 2 > BEYOND * step)


def judged(where: str, channels: Mapping[str, Channel], kinds: Kinds) -> list[Finding]:
    """Constant channels, ranges that suggest another unit, short runs, swapped axes."""
    notes: list[Finding] = []
    for name, channel in channels.items():
        if not channel.valid.any():
            notes.append(Finding("nan", where, f"no sample of {name} may be used", False))
            continue
        for axis, column in enumerate(channel.values.T):
            used = column[channel.valid]  # one axis at a time: long logs are large
            low, high = float(used.min()), float(used.max())
            largest = LARGEST[kinds[axis] if axis < len(kinds) else ROTARY]
            if name in largest and max(-low, high) > largest[name]:
                text = f"{name}[{axis + 1}] reaches {max(-low, high):.4g}: is its unit right?"
                notes.append(Finding("range", where, text, False))
            if name in NEEDED and low == high:
                text = f"{name}[{axis + 1}] is {low:.6g} throughout"
                notes.append(Finding("constant", where, text, False))
    theta = channels["theta"]
    if (seconds := len(theta.values) * theta.ts) < SHORT:
        notes.append(Finding("short", where, f"only {seconds:.3g} s long", False))
    if "r" in channels:
        notes += _swapped(where, channels["theta"], channels["r"])
    return notes


def _swapped(where: str, theta: Channel, r: Channel) -> list[Finding]:
    """Angles that follow another axis' reference, or their own with the sign turned."""
    if theta.width != r.width:
        text = f"{theta.width} angles but {r.width} references: order of axes not checked"
        return [Finding("missing", where, text, False)]
    every = max(1, len(theta.values) // 20000)
    angle = _centred(theta.values[::every])
    times = theta.time[::every]
    clock = r.time
    want = _centred(np.column_stack([np.interp(times, clock, column) for column in r.values.T]))
    size = np.sqrt((want**2).mean(axis=0))
    if not (size > 0).all():
        return []
    apart = np.array([[_rms(a - b) for b in want.T] for a in angle.T]) / size
    own = np.diagonal(apart)
    from scipy.optimize import linear_sum_assignment  # takes long to load

    rows, columns = linear_sum_assignment(apart)
    moved = [
        (i, j)
        for i, j in zip(rows, columns, strict=True)
        if i != j and apart[i, j] < FOLLOWS and own[i] > STRANGER
    ]
    notes = []
    if moved:
        pairs = ", ".join(f"theta[{i + 1}] follows r[{j + 1}]" for i, j in moved)
        notes.append(Finding("swapped", where, f"axes are swapped: {pairs}", False))
    for i in range(theta.width):
        if own[i] > STRANGER and _rms(angle[:, i] + want[:, i]) / size[i] < FOLLOWS:
            text = f"theta[{i + 1}] follows -r[{i + 1}]: its sign is turned"
            notes.append(Finding("sign", where, text, False))
    return notes


def _centred(values: Array) -> Array:
    return np.asarray(values - values.mean(axis=0))


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))
