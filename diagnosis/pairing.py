"""Whether logs and base model agree on axes, signs and units, before anything is fitted.

The nominal torque of a motion, with friction and a rotor on each axis that cannot be negative, is
compared with the log's as it is, and as it would be with axes exchanged, signs turned or other
units. A fit would turn masses negative to please such a log.
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
NEARLY = 2.0
"""Factor by which the nominal torque may be wrong."""
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
    """What the log might mean: column of each axis, factors of its angle and torque."""

    text: str
    order: tuple[int, ...]
    angle: Array
    torque: Array

    def of(self, seen: Seen) -> Seen:
        """The run as it would be then."""
        order = list(self.order)
        q, v, a = (x[:, order] * self.angle for x in (seen.theta, seen.thetad, seen.thetadd))
        return Seen(q, v, a, seen.tau[:, order] * self.torque, seen.payload)


def mispaired(base: Base, runs: Sequence[Run]) -> str:
    """How the logs should be rearranged to be those of the base model, or nothing; nothing, too,
    of a base model without nominal values."""
    if base.complete or not any(k.nominal and 0 < k.tolerance < np.inf for k in base.linear):
        return ""
    seen = [s for run in _first_passes(runs) if (s := _seen(run, base.window)) is not None]
    if not seen:
        return ""
    texts, now = list[str](), _left(base, seen)
    while now.max() > BADLY and len(texts) < base.n:
        tried = [(a, [a.of(s) for s in seen]) for a in _arrangements(base)]
        scored = [(float(_left(base, moved).sum()), k) for k, (_, moved) in enumerate(tried)]
        least, best = min(scored)
        if least > BETTER * now.sum():
            break
        arrangement, seen = tried[best]
        texts.append(arrangement.text)
        now = _left(base, seen)
    if not texts:
        return ""
    return (
        f"the torques are not those of the base model on this motion; they would be with"
        f" {' and '.join(texts)}: mend the logs, or the model"
    )


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
                order = list(same)
                order[i], order[j] = j, i
                yield Arrangement(f"axes {j + 1} and {i + 1} exchanged", tuple(order), ones, ones)
    yield Arrangement("all torques negated", same, ones, -ones)
    for times, unit in ((1e-3, "a thousandth"), (1e3, "a thousand times")):
        yield Arrangement(f"torques of {unit} their size (units?)", same, ones, times * ones)
    if all(kind.turns for kind in kinds):
        yield Arrangement("angles taken as degrees, not radians", same, np.deg2rad(ones), ones)


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
