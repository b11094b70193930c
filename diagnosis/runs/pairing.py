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

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.kinds import axes_named, kinds_of
from flexhex.diagnosis.runs.arrangements import THOUSANDS, Arrangement, Seen, arrangements, zeros
from flexhex.diagnosis.runs.mirrored import mirrored
from flexhex.diagnosis.runs.mounted import mounted
from flexhex.diagnosis.runs.nominal import NEARLY, left_of, not_below_zero, scaled
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.smoothing import hann_weights

Array = NDArray[np.float64]
INSTANTS = 300
"""Of each trajectory."""
LEAST = 1e-6
"""Share of the mean square below which nothing is better: what rounding leaves."""
EVIDENCE = 4.0
"""Factor by which an arrangement lowers the product of what is left of all axes, relative to the
less of what the file and what friction, rotors and offsets alone leave of each: then it is better,
as these alone are on an axis.
On measured and simulated logs that are right it is 2.4 at most, but for one axis of an opposite
sign; of an arm that is mostly friction 5.5 at least where axes are exchanged."""
BADLY, MENDED = 0.25, 0.3
"""Share of an axis' mean square that is too much to be left; and sum of these shares, relative to
what was left before, from which a log is refused although an axis is still bad; else no arrangement
is the reason."""
DOUBTFUL = 0.1
"""Share that is said, of the torque or beyond all of it. Logs of the right model leave 0.06 at most
(UR10e, simulated arm)."""
FORM = 0.25
"""Share of an axis' mean square that the nominal torque explains where its form is seen."""


def mispaired(base: Base, runs: Sequence[Run]) -> str:
    """How the logs should be rearranged to be those of the base model, or nothing; nothing, too,
    of a base model without nominal values, and where other sizes of torques alone are better: they
    cannot be told from other masses."""
    seen = _all_seen(base, runs)
    if not seen:
        return ""
    texts, refused, first = list[str](), False, left_of(base, seen)
    now = first
    while len(texts) < base.n:
        better = _best(base, seen)
        if better is None or better.text in texts or np.any(better.zero):
            break
        texts.append(better.text)
        refused |= not better.sized
        seen = [better.of(s) for s in seen]
        now = left_of(base, seen)
    if not refused or (now.max() > BADLY and now.sum() > MENDED * first.sum()):
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
    left = left_of(base, seen)
    worse = left > EVIDENCE * left_of(base, seen, without=True)
    # an offset of a machine that lacks no weight is that of friction
    worse |= left_of(base, seen, offset=False) > 1 + DOUBTFUL
    better = _best(base, seen)
    parts = []
    if (bad := (left > DOUBTFUL) | worse).any():
        parts.append(
            f"the values of the base model, friction and rotors leave {_share(left[bad].max())} the"
            f" mean square of the torque of {axes_named(np.flatnonzero(bad))}"
        )
    if worse.any():
        parts.append(f"friction and rotors alone leave less on {axes_named(np.flatnonzero(worse))}")
    if better := better or mirrored(base, seen):
        parts.append(f"less would be left with {better.text}")
    if not parts:
        return ""
    return (
        f"{'; '.join(parts)}. Unless the model lacks that much: is it this machine's, are its"
        " joints in the order of the log, their signs, zeros and units the log's?"
    )


def _many_times(base: Base, seen: Sequence[Seen]) -> str:
    """Axes whose torque is the nominal one many times over, or a small part of it; or nothing."""
    times = dict[int, float]()
    for i in range(base.n):
        nominal, others, tau = scaled(base, seen, i)
        x, norm = not_below_zero(np.column_stack([nominal, others]), tau)
        left, without = (r**2 / len(tau) for r in (norm, not_below_zero(others, tau)[1]))
        if left > DOUBTFUL:
            # another size is not the reason
            return ""
        if without - left > FORM and not 1 / NEARLY <= x[0] <= NEARLY:
            times[i + 1] = float(x[0])
    if not times:
        return ""
    listed = " and ".join(f"{share:.2g} times that on axis {axis}" for axis, share in times.items())
    return (
        "the torque has the form that the base model's values give, but is"
        f" {listed}: another machine's file, a payload that the model lacks, a current, a gear, or"
        " times that are wrong?"
    )


def _share(left: float) -> str:
    return f"{left:.0%} of" if left < 10 else "many times"


def _all_seen(base: Base, runs: Sequence[Run]) -> list[Seen]:
    """The runs; none for a base model without nominal values, or one that is not complete yet, or
    where a torque never changes."""
    if base.complete or not any(k.nominal and k.tolerance < np.inf for k in base.linear):
        return []
    seen = [s for run in _first_passes(runs) if (s := _seen(run, base.window)) is not None]
    return seen if seen and np.ptp(np.concatenate([s.tau for s in seen]), axis=0).all() else []


def _best(base: Base, seen: Sequence[Seen]) -> Arrangement | None:
    """The arrangement that leaves least, if that is much less than now; one that only makes torques
    larger or smaller, which leaves less of whatever is wrong, where there is no other."""
    listed = [*arrangements(base), *zeros(base), *mounted(base, seen)]
    return _better(base, seen, listed) or _better(base, seen, list(_factors(base, seen)))


def _better(base: Base, seen: Sequence[Seen], listed: Sequence[Arrangement]) -> Arrangement | None:
    """The arrangement of these that leaves least, the first of several, if it is better by
    `EVIDENCE`. A nominal torque that it takes to nothing is no evidence; friction that is below
    zero without it is."""
    if not listed:
        return None
    now = np.minimum(left_of(base, seen), left_of(base, seen, without=True))
    scored = np.zeros(len(listed))
    for k, arrangement in enumerate(listed):
        left = left_of(base, [arrangement.of(s) for s in seen])
        before = now[list(arrangement.efforts or arrangement.order)]
        scored[k] = np.log(np.maximum(before, LEAST) / np.maximum(left, LEAST)).sum()
    best = int(np.argmax(np.round(scored, 2)))
    return listed[best] if scored[best] >= np.log(EVIDENCE) else None


def _factors(base: Base, seen: Sequence[Seen]) -> Iterator[Arrangement]:
    """Torques that are the nominal ones times some number, as currents are, or torques of motors
    before their gears; thousands apart, which have a name."""
    same, ones = tuple(range(base.n)), np.ones(base.n)
    named = np.log([times for times, _ in THOUSANDS])
    for i, kind in enumerate(kinds_of(base, base.n)):
        nominal, others, tau = scaled(base, seen, i)
        share = float(not_below_zero(np.column_stack([nominal, others]), tau)[0][0])
        if share <= 0 or 1 / NEARLY < share < NEARLY:
            continue
        if np.abs(named + np.log(share)).min() > np.log(NEARLY):
            times = np.where(np.arange(base.n) == i, 1 / share, 1.0)
            text = (
                f"the {kind.effort} of axis {i + 1} times {1 / share:.2g} (a current, or a gear?)"
            )
            yield Arrangement(text, same, ones, times, sized=True)


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
