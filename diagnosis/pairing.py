"""Whether logs and base model agree on axes, signs and units, before anything is fitted.

The nominal torque of a motion, with friction and a rotor on each axis that cannot be negative, is
compared with the log's as it is, and as it would be with axes exchanged, signs turned or other
units. A fit would turn masses negative to please such a log. Where no such change mends it, or
little is wrong, it is said and nothing is refused: an effect that the model lacks may be as large.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from flexhex.diagnosis.base import Base, Motion
from flexhex.diagnosis.blocks import Run
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.smoothing import hann_weights

Array = NDArray[np.float64]
INSTANTS = 300
"""Of each trajectory."""
BADLY, BETTER = 0.25, 0.5
"""Share of an axis' mean square that is too much to be left; and share of all that, relative to
what was left before, at which another arrangement is right."""
MENDED = 0.3
"""Sum of these shares, relative to what was left before, from which a log is refused although an
axis is still bad; else no arrangement is the reason."""
DOUBTFUL = 0.1
"""Share that is said. Logs of the right model leave 0.06 at most (UR10e, simulated arm)."""
NEARLY = 2.0
"""Factor by which the nominal torque may be wrong."""
THOUSANDS = ((1e-3, "a thousandth"), (1e3, "a thousand times"))
"""Units that are taken for each other."""
SHARP = 0.05
"""Rate, relative to its RMS, at which dry friction is there."""


@dataclass(frozen=True)
class Seen:
    """Smoothed motion and torque (samples, n) of a run at some instants; payload [kg]."""

    theta: Array
    thetad: Array
    thetadd: Array
    tau: Array
    payload: float


@dataclass(frozen=True)
class Arrangement:
    """What the log might mean: column of each axis' angle, and of its torque; factors of both;
    what is added to the angles [rad]."""

    text: str
    order: tuple[int, ...]
    angle: Array
    torque: Array
    efforts: tuple[int, ...] = ()
    zero: Array | float = 0.0

    def of(self, seen: Seen) -> Seen:
        """The run as it would be then."""
        order, efforts = list(self.order), list(self.efforts or self.order)
        q, v, a = (x[:, order] * self.angle for x in (seen.theta, seen.thetad, seen.thetadd))
        return Seen(q + self.zero, v, a, seen.tau[:, efforts] * self.torque, seen.payload)


def mispaired(base: Base, runs: Sequence[Run]) -> str:
    """How the logs should be rearranged to be those of the base model, or nothing; nothing, too,
    of a base model without nominal values."""
    seen = _all_seen(base, runs)
    if not seen:
        return ""
    texts, first = list[str](), _left(base, seen)
    now = first
    while now.max() > BADLY and len(texts) < base.n:
        better = _better(base, seen, now, list(_arrangements(base)))
        if better is None:
            break
        texts.append(better.text)
        seen = [better.of(s) for s in seen]
        now = _left(base, seen)
    if not texts or (now.max() > BADLY and now.sum() > MENDED * first.sum()):
        return ""
    return (
        f"the torques are not those of the base model on this motion; they would be with"
        f" {' and '.join(texts)}: mend the logs, or the model"
    )


def doubtful(base: Base, runs: Sequence[Run]) -> str:
    """Axes whose torque the nominal one does not come near to, and what would mend it; or
    nothing."""
    seen = _all_seen(base, runs)
    if not seen:
        return ""
    left = _left(base, seen)
    axes = [str(i + 1) for i, share in enumerate(left) if share > DOUBTFUL]
    if not axes:
        return ""
    better = _better(base, seen, left, [*_arrangements(base), *_zeros(base)])
    hint = f"; less would be with {better.text}" if better is not None else ""
    return (
        f"with the values of the base model, friction and rotors, {left.max():.0%} of the mean"
        f" square stays of the torque of axis {', '.join(axes)}{hint}. Unless the machine lacks"
        " that much: is the model this machine's, are its joints in the order of the log, their"
        " signs, zeros and units the log's?"
    )


def _all_seen(base: Base, runs: Sequence[Run]) -> list[Seen]:
    """The runs; none for a base model without nominal values, or one that is not complete yet."""
    if base.complete or not any(k.nominal and 0 < k.tolerance < np.inf for k in base.linear):
        return []
    return [s for run in _first_passes(runs) if (s := _seen(run, base.window)) is not None]


def _better(
    base: Base, seen: Sequence[Seen], now: Array, listed: Sequence[Arrangement]
) -> Arrangement | None:
    """The arrangement that leaves least, if that is much less than now."""
    scored = [float(_left(base, [a.of(s) for s in seen]).sum()) for a in listed]
    best = int(np.argmin(scored))
    return listed[best] if scored[best] <= BETTER * now.sum() else None


def _zeros(base: Base) -> Iterator[Arrangement]:
    """Angles with another zero, which looks much like a spring that the model lacks."""
    same, ones = tuple(range(base.n)), np.ones(base.n)
    for i, kind in enumerate(kinds_of(base, base.n)):
        for quarter in (1, 2, 3) if kind.turns else ():
            zero = np.where(np.arange(base.n) == i, quarter * np.pi / 2, 0.0)
            text = f"{90 * quarter} degrees added to the {kind.position} of axis {i + 1}"
            yield Arrangement(text, same, ones, ones, (), zero)


def _arrangements(base: Base) -> Iterator[Arrangement]:
    n, kinds = base.n, kinds_of(base, base.n)
    same, ones = tuple(range(n)), np.ones(n)
    for i in range(n):
        turned = np.where(np.arange(n) == i, -1.0, 1.0)
        word, effort = kinds[i].position, kinds[i].effort
        yield Arrangement(f"the {effort} of axis {i + 1} negated", same, ones, turned)
        yield Arrangement(f"the {word} of axis {i + 1} negated", same, turned, ones)
        yield Arrangement(f"{word} and {effort} of axis {i + 1} negated", same, turned, turned)
        for j in range(i):
            if kinds[i] is kinds[j]:
                swapped = list(same)
                swapped[i], swapped[j] = j, i
                both, of = f"{j + 1} and {i + 1} exchanged", tuple(swapped)
                yield Arrangement(f"axes {both}", of, ones, ones)
                yield Arrangement(f"the {effort}s of axes {both}", same, ones, ones, of)
        for times, unit in THOUSANDS:
            one = np.where(np.arange(n) == i, times, 1.0)
            yield Arrangement(f"the {effort} of axis {i + 1} of {unit} its size", same, ones, one)
        if kinds[i].turns:
            one = np.where(np.arange(n) == i, np.deg2rad(1.0), 1.0)
            text = f"the {word} of axis {i + 1} taken as degrees, not radians"
            yield Arrangement(text, same, one, ones)
    if len(set(kinds)) == 1 and n > 2:
        yield Arrangement("the axes in reverse order", same[::-1], ones, ones)
        for k in range(1, n):
            order = (*same[k:], *same[:k])
            yield Arrangement(f"axis {k + 1} as the first, the others after it", order, ones, ones)
    yield Arrangement("all torques negated", same, ones, -ones)
    yield Arrangement("all angles and torques negated", same, -ones, -ones)
    for times, unit in THOUSANDS:
        yield Arrangement(f"torques of {unit} their size (units?)", same, ones, times * ones)
    if all(kind.turns for kind in kinds):
        yield Arrangement("angles taken as degrees, not radians", same, np.deg2rad(ones), ones)
        yield Arrangement("angles taken as radians, not degrees", same, np.rad2deg(ones), ones)


def _left(base: Base, seen: Sequence[Seen]) -> Array:
    """Share (n,) of each axis' mean square that nominal torque, friction and rotor leave."""
    nominal = np.array([known.nominal for known in base.linear])
    model = np.concatenate([_torque(base, s, nominal) for s in seen])
    rate, acceleration, tau = (
        np.concatenate([getattr(s, name) for s in seen]) for name in ("thetad", "thetadd", "tau")
    )
    found = np.zeros(base.n)
    for i in range(base.n):
        speed = rate[:, i] / max(float(np.sqrt((rate[:, i] ** 2).mean())), 1e-300)
        others = [np.tanh(speed / SHARP), speed, acceleration[:, i], np.ones(len(speed))]
        columns = np.stack([model[:, i], *others], axis=1)
        size = np.maximum(np.sqrt((columns**2).mean(axis=0)), 1e-300)
        size[0] = 1.0
        low, high = [1 / NEARLY, 0.0, 0.0, 0.0, -np.inf], [NEARLY, *(np.inf,) * 4]
        unit = max(float(tau[:, i].std()), 1e-300)
        solved = lsq_linear(columns / size / unit, tau[:, i] / unit, (low, high))
        found[i] = 2 * solved.cost / len(speed)
    return found


def _torque(base: Base, seen: Seen, nominal: Array) -> Array:
    motion = Motion(0.0, 1.0, seen.theta, seen.thetad, seen.thetadd)
    return base.torque(motion, base.loaded(nominal, seen.payload))


def _first_passes(runs: Sequence[Run]) -> list[Run]:
    """The first run of each trajectory."""
    return list({run.trajectory: run for run in reversed(runs)}.values())


def _seen(run: Run, window: float) -> Seen | None:
    """A run at instants that motion and torque have both; None where there are none."""
    motion, tau = run.motion, run.tau
    clock = motion.time
    at = np.linspace(clock[0] + window, clock[-1] - window, INSTANTS)
    weights, moved = hann_weights(at, motion.t0, motion.ts, run.valid, window)
    felt, known = hann_weights(at, tau.t0, tau.ts, tau.valid, window)
    both = moved & known
    if not both.any():
        return None
    q, v, a = ((weights @ x)[both] for x in (motion.theta, motion.thetad, motion.thetadd))
    return Seen(q, v, a, (felt @ tau.values)[both], run.payload)
