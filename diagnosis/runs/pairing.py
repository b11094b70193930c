"""Whether logs and base model agree on axes, signs and units, before anything is fitted.

The nominal torque of a motion, with friction and a rotor on each axis that cannot be negative, is
compared with the log's as it is, and as it would be with axes exchanged, signs turned or other
units. A fit would turn masses negative to please such a log. Where no such change mends it, or
little is wrong, it is said and nothing is refused: an effect that the model lacks may be as large.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.runs.arrangements import THOUSANDS, Arrangement, Seen, arrangements, zeros
from flexhex.diagnosis.runs.blocks import Run
from flexhex.diagnosis.runs.smoothing import hann_weights

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
HOPELESS, RIGHT = 0.9, 0.1
"""Share of what friction, rotors and offsets alone leave from which the nominal torque explains
nothing; what an arrangement may leave of that to be the reason, although no axis is bad."""
SHARP = 0.05
"""Rate, relative to its RMS, at which dry friction is there."""


def mispaired(base: Base, runs: Sequence[Run]) -> str:
    """How the logs should be rearranged to be those of the base model, or nothing; nothing, too,
    of a base model without nominal values."""
    seen = _all_seen(base, runs)
    if not seen:
        return ""
    texts, first = list[str](), _left(base, seen)
    nothing, now = _left(base, seen, without=True), first
    hopeless = first.sum() > HOPELESS * nothing.sum()
    while (now.max() > BADLY or (hopeless and not texts)) and len(texts) < base.n:
        better = _better(base, seen, now, [*arrangements(base), *zeros(base)])
        if better is None or better.text in texts or np.any(better.zero):
            break
        texts.append(better.text)
        seen = [better.of(s) for s in seen]
        now = _left(base, seen)
    if not texts or (now.max() > BADLY and now.sum() > MENDED * first.sum()):
        return ""
    if first.max() <= BADLY and now.sum() > RIGHT * nothing.sum():
        return ""
    return (
        f"the torques are not those of the base model on this motion; they would be with"
        f" {' and '.join(texts)}: mend the logs, or the model"
    )


def doubtful(base: Base, runs: Sequence[Run]) -> str:
    """Axes whose torque the nominal one does not come near to, and what would mend it; or those
    whose torque is many times the nominal one; or nothing."""
    seen = _all_seen(base, runs)
    if not seen:
        return ""
    if text := _many_times(base, seen):
        return text
    left = _left(base, seen)
    axes = [str(i + 1) for i, share in enumerate(left) if share > DOUBTFUL]
    if not axes:
        return ""
    better = _better(base, seen, left, [*arrangements(base), *zeros(base)])
    hint = f"; less would be with {better.text}" if better is not None else ""
    return (
        f"with the values of the base model, friction and rotors, {_share(left.max())} of the mean"
        f" square stays of the torque of axis {', '.join(axes)}{hint}. Unless the machine lacks"
        " that much: is the model this machine's, are its joints in the order of the log, their"
        " signs, zeros and units the log's?"
    )


def _many_times(base: Base, seen: Sequence[Seen]) -> str:
    """Axes whose torque is the nominal one many times over, or a small part of it; or nothing."""
    from scipy.optimize import lsq_linear  # takes long to load

    times = dict[int, float]()
    for i in range(base.n):
        columns, tau = _scaled(base, seen, i)
        low = [0.0, 0.0, 0.0, 0.0, -np.inf]
        fit = lsq_linear(columns, tau, (low, np.inf))
        alone = lsq_linear(columns[:, 1:], tau, (low[1:], np.inf))
        left, without = (2 * of.cost / len(tau) for of in (fit, alone))
        if left > DOUBTFUL:
            # another size is not the reason
            return ""
        if without - left > BADLY and not 1 / NEARLY <= fit.x[0] <= NEARLY:
            times[i + 1] = float(fit.x[0])
    if not times:
        return ""
    listed = " and ".join(f"{share:.2g} times that on axis {axis}" for axis, share in times.items())
    return (
        "the torque has the form that the base model's values give, but is"
        f" {listed}: another machine's file, a payload that the model lacks, a current, a gear, or"
        " times that are wrong?"
    )


def _share(left: float) -> str:
    return f"{left:.0%}" if left < 10 else "many times all"


def _all_seen(base: Base, runs: Sequence[Run]) -> list[Seen]:
    """The runs; none for a base model without nominal values, or one that is not complete yet, or
    where a torque never changes."""
    if base.complete or not any(k.nominal and 0 < k.tolerance < np.inf for k in base.linear):
        return []
    seen = [s for run in _first_passes(runs) if (s := _seen(run, base.window)) is not None]
    return seen if seen and np.ptp(np.concatenate([s.tau for s in seen]), axis=0).all() else []


def _better(
    base: Base, seen: Sequence[Seen], now: Array, listed: Sequence[Arrangement]
) -> Arrangement | None:
    """The arrangement that leaves least, if that is much less than now, and than friction, rotors
    and offsets leave alone: torques that an arrangement takes to nothing are no better."""
    listed = [*listed, *_factors(base, seen)]
    scored = [float(_left(base, [a.of(s) for s in seen]).sum()) for a in listed]
    best = int(np.argmin(scored))
    alone = _left(base, [listed[best].of(s) for s in seen], without=True).sum()
    return listed[best] if scored[best] <= BETTER * min(now.sum(), alone) else None


def _factors(base: Base, seen: Sequence[Seen]) -> Iterator[Arrangement]:
    """Torques that are the nominal ones times some number, as currents are, or torques of motors
    before their gears; thousands apart, which have a name."""
    same, ones = tuple(range(base.n)), np.ones(base.n)
    named = np.log([times for times, _ in THOUSANDS])
    for i, kind in enumerate(kinds_of(base, base.n)):
        columns, tau = _scaled(base, seen, i)
        # none of them can be negative but the offset
        share = float(_not_below_zero(np.column_stack([columns, -columns[:, -1]]), tau)[0][0])
        if share <= 0 or 1 / NEARLY < share < NEARLY:
            continue
        if np.abs(named + np.log(share)).min() > np.log(NEARLY):
            times = np.where(np.arange(base.n) == i, 1 / share, 1.0)
            text = (
                f"the {kind.effort} of axis {i + 1} times {1 / share:.2g} (a current, or a gear?)"
            )
            yield Arrangement(text, same, ones, times)


def _scaled(base: Base, seen: Sequence[Seen], axis: int) -> tuple[Array, Array]:
    """See `_columns`, of the nominal torque."""
    nominal = _nominal(base)
    model = np.concatenate([_torque(base, s, nominal)[:, axis] for s in seen])
    return _columns(seen, model, axis)


def _left(base: Base, seen: Sequence[Seen], without: bool = False) -> Array:
    """Share (n,) of each axis' mean square that nominal torque, friction and rotor leave; without:
    those that friction and rotor leave alone."""
    nominal = _nominal(base) * (not without)
    model = np.concatenate([_torque(base, s, nominal) for s in seen])
    shares = np.zeros(base.n)
    for i in range(base.n):
        columns, tau = _columns(seen, model[:, i], i)
        shares[i] = _least(columns, tau) / len(tau)
    return shares


def _least(columns: Array, tau: Array) -> float:
    """Sum of squares that columns (samples, 5) leave at best: the first, of the nominal torque,
    times 1 / NEARLY to NEARLY, the others not below zero, but for the last, an offset."""
    nominal, others = columns[:, 0], np.column_stack([columns[:, 1:], -columns[:, -1]])
    # beside its least share nothing is below zero
    x, norm = _not_below_zero(np.column_stack([nominal, others]), tau - nominal / NEARLY)
    if x[0] > NEARLY - 1 / NEARLY:
        norm = _not_below_zero(others, tau - NEARLY * nominal)[1]
    return float(norm**2)


def _not_below_zero(columns: Array, tau: Array) -> tuple[Array, float]:
    """Coefficients (k,), none negative, and the norm of what they leave."""
    from scipy.optimize import nnls  # takes long to load

    x, norm = nnls(columns, tau)
    return x, float(norm)


def _columns(seen: Sequence[Seen], model: Array, axis: int) -> tuple[Array, Array]:
    """Nominal torque (samples,) of an axis with friction, rotor and offset (samples, 5), and its
    measured torque (samples,), both relative to the deviation of the latter."""
    rate, acceleration, tau = (
        np.concatenate([getattr(s, name)[:, axis] for s in seen])
        for name in ("thetad", "thetadd", "tau")
    )
    speed = rate / max(float(np.sqrt((rate**2).mean())), 1e-300)
    others = np.stack([np.tanh(speed / SHARP), speed, acceleration, np.ones(len(speed))], axis=1)
    size = np.maximum(np.sqrt((others**2).mean(axis=0)), 1e-300)
    unit = max(float(tau.std()), 1e-300)
    return np.column_stack([model / unit, others / size]), tau / unit


def _nominal(base: Base) -> Array:
    """Parameters of the base model as they are written (n_p,)."""
    return np.array([known.nominal for known in base.linear])


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
