"""Which effect explains what repeats: one round of candidates after the other.

A candidate counts when its Wald test, robust to errors that go together within a second, passes
at 1 % of all candidates together, and when it also explains a trajectory that it was not fitted
to. Effects that do nearly as well as the best one are its rivals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.rivals import NEAR, clarified, rivals
from flexhex.diagnosis.scored import Found, Scored, allowed, leaders
from flexhex.diagnosis.stacked import whole

Array = NDArray[np.float64]
MOST, ROUNDS = 4, 8
"""Most effects of a diagnosis; an effect may come again with another shape."""
LEVEL = 0.01
"""False alarms that all candidates together may raise."""
LEAST_SHARE, LEAST_FIRST = 0.12, 0.04
"""Share of what repeats on its axis that an effect must explain on trajectories left out: of what
is left in its round, and of what was there at first."""
SMALLEST = 0.0015
"""Smallest effect that is worth naming, RMS relative to the torque's."""
LEAST_KIN = 0.5
"""The same of what is left, beside an effect with which the library confuses it."""
TIE = 0.98
"""Of effects this close to the best the one with the fewest shapes to choose from is named."""
SAME_SHAPE = 0.05
"""Relative difference of shapes that two axes may have for one reason."""
MINOR = 0.05
"""An axis joins an effect's others when it gains this share of the best one; what is left of it
comes again in the next round."""


@dataclass(frozen=True)
class Round:
    """What was tried in one round: totals over axes by effect, and what was chosen."""

    tried: tuple[Found, ...]
    shares: dict[str, float]
    chosen: Found | None


Say = Callable[[str], None]


def search(bench: Bench, say: Say = lambda text: None) -> list[Round]:
    """Rounds until nothing more is found."""
    rounds: list[Round] = []
    regression = bench.made.regression
    first = unexplained(bench.made, regression)
    while len(rounds) < ROUNDS:
        say(f"effects, round {len(rounds) + 1}")
        known = [part for r in rounds if r.chosen for part in r.chosen.parts]
        found = one_round(bench, regression, first, known)
        rounds.append(found)
        ids = {r.chosen.id for r in rounds if r.chosen}
        if found.chosen is None or len(ids) > MOST:
            break
        regression = regression.extended([part.columns for part in found.chosen.parts])
    chosen = iter(clarified(bench, bench.made.regression, [r.chosen for r in rounds if r.chosen]))
    return [replace(r, chosen=next(chosen)) if r.chosen else r for r in rounds]


def one_round(
    bench: Bench, regression: Regression, first: Array, known: Sequence[Scored] = ()
) -> Round:
    """Score all candidates beside the columns of a regression, and choose.

    first (n,): what repeated before the first round; known: what was found since.
    """
    energy = unexplained(bench.made, regression)
    count = _count(bench)
    passing: dict[str, list[Scored]] = {}
    places = [p for p in (None, *range(bench.n)) if _worth(bench, energy, p)]
    for axis in places:
        for scored in leaders(bench, regression, axis):
            certain = scored.gain.p < LEVEL / count and scored.gain.outside > 0
            if certain and allowed(bench, scored):
                passing.setdefault(scored.id, []).append(scored)
    shares = {
        name: sum(s.gain.outside for s in parts) / max(_energy(energy, parts), 1e-300)
        for name, parts in passing.items()
    }
    tried = sorted(
        (Found(name, tuple(parts), ()) for name, parts in passing.items()),
        key=lambda found: found.outside,
        reverse=True,
    )
    large = []
    for found in tried:
        parts = [p for p in found.parts if _large(bench, regression, p, energy, first, known)]
        if parts:
            large.append(replace(found, parts=_own(bench, _major(parts), tried)))
    chosen = None
    if large:
        winner = min(_ties(regression, large), key=lambda found: _choices(bench, found))
        chosen = Found(winner.id, winner.parts, rivals(bench, winner, tried))
    return Round(tuple(tried), shares, chosen)


def _major(parts: Sequence[Scored]) -> tuple[Scored, ...]:
    """Parts that are not dwarfed by another: what a strong effect does to the fit of the base
    model shows on all axes."""
    most = max((part.gain.outside for part in parts), default=0.0)
    return tuple(part for part in parts if part.gain.outside >= MINOR * most)


def _own(bench: Bench, parts: Sequence[Scored], tried: Sequence[Found]) -> tuple[Scored, ...]:
    """Parts without those of another shape than the largest one that something simpler explains
    about as well on their axis: a harmonic of another order for a curved spring's."""
    largest = max(parts, key=lambda part: part.gain.outside)
    simpler = [f for f in tried if _choices(bench, f) < _choices(bench, largest)]
    best: dict[int | None, float] = {}
    for other in (part for found in simpler for part in found.parts):
        best[other.axis] = max(best.get(other.axis, 0.0), other.gain.outside)
    return tuple(
        part
        for part in parts
        if _same(part, largest) or TIE * part.gain.outside > best.get(part.axis, -np.inf)
    )


def _same(part: Scored, other: Scored) -> bool:
    """Whether two parts of an effect have about the same shape."""
    return all(
        abs(value - other.shape[name]) <= SAME_SHAPE * abs(other.shape[name])
        for name, value in part.shape.items()
    )


def _ties(regression: Regression, large: Sequence[Found]) -> list[Found]:
    """The first, and what comes so near that chance may decide: on all axes together, or on its own
    axes where these hold nearly all."""
    gains = [_together(regression, found) for found in large]
    most = max(gains)
    best = large[gains.index(most)]
    return [
        found
        for found, gained in zip(large, gains, strict=True)
        if gained >= TIE * most or (gained >= NEAR * most and _as_well(found, best))
    ]


def _as_well(found: Found, best: Found) -> bool:
    """Whether an effect gains as much as the best one on each axis that it is on."""
    most = {part.axis: part.gain.outside for part in best.parts}
    return all(part.gain.outside >= TIE * most.get(part.axis, np.inf) for part in found.parts)


def _together(regression: Regression, found: Found) -> float:
    """What the parts gain together: what several of them explain, as what one axis lacks shows on
    all in the base model's fit, counts once."""
    if len(found.parts) == 1:
        return found.outside
    columns = np.hstack([whole(regression, part.columns) for part in found.parts])
    return regression.gain(Columns(None, columns)).outside


def _choices(bench: Bench, found: Found | Scored) -> int:
    """Shapes that a search may choose from: the more, the better it fits by chance."""
    item = bench.effects.get(found.id)
    return len(item.shapes) if item else 1


def unexplained(made: Calibrated, regression: Regression) -> Array:
    """What repeats (n,), and by how much the parameters had to leave their tolerances for it."""
    return repeating(made, regression.residual) + regression.strain


def repeating(made: Calibrated, residual: Array) -> Array:
    """Sum of squares of what repeats of a whitened residual (R,), for each axis (n,).

    Without repeats the sum of all squares, an upper bound.
    """
    products = (made.layout.twin(residual) if made.between else residual) * residual
    total = [products[made.layout.rows(i)].sum() for i in range(made.base.n)]
    return np.asarray(np.maximum(np.array(total), 0.0))


def _count(bench: Bench) -> int:
    shapes = sum(len(item.shapes) for item in bench.effects.values())
    return bench.n * shapes + len(bench.whole)


def _worth(bench: Bench, energy: Array, axis: int | None) -> bool:
    """Whether what repeats on an axis could hold an effect that is large enough."""
    rows = len(bench.made.regression.y) / bench.n
    size = np.sqrt(energy / rows) * _unit(bench.made)
    large = size > SMALLEST * bench.made.torque_rms
    return bool(large.any() if axis is None else large[axis])


def _unit(made: Calibrated) -> Array:
    """Torque (n,) [N m] that a whitened one stands for: the noise's own.

    Where products are not taken between passes noise is among them, and only what stands out of
    its innovations counts.
    """
    return made.noise.floor if made.between else made.noise.scale


def _energy(energy: Array, parts: Sequence[Scored]) -> float:
    axes = [part.axis for part in parts]
    return float(energy.sum() if None in axes else sum(energy[a] for a in axes if a is not None))


def _large(
    bench: Bench,
    regression: Regression,
    part: Scored,
    energy: Array,
    first: Array,
    known: Sequence[Scored],
) -> bool:
    """Whether an effect on an axis is large enough to be named.

    What the library confuses with an effect already found there must explain most of what is
    left: else it makes up for a form that nature does not quite have.
    """
    made = bench.made
    axes = list(range(bench.n)) if part.axis is None else [part.axis]
    rows = len(made.regression.y) / bench.n * len(axes)
    least, gained = SMALLEST * float(made.torque_rms[axes].mean()), max(part.gain.outside, 0.0)
    if not made.between:  # the noise itself is among what is left, and what is slow is whitened
        return gained > 0 and _torque(bench, regression, part) > least
    size = np.sqrt(gained / rows) * float(_unit(made)[axes].mean())
    if size < least and part.axis is not None and gained > 0:
        # what is slow is larger than it seems among whitened rows
        size = _torque(bench, regression, part)
    if size < least:
        return False
    least = LEAST_KIN if any(_kin(bench, part, other) for other in known) else LEAST_SHARE
    shares = least * energy[axes].sum(), LEAST_FIRST * first[axes].sum()
    return bool(gained > max(shares))


def _torque(bench: Bench, regression: Regression, part: Scored) -> float:
    """RMS [N m] of an effect on an axis (None: on all), without what the base model takes on in its
    fit. An encoder's error on one axis makes torques on all: they count together."""
    made, C, own = bench.made, part.columns, part.axis
    moved = regression.solve(regression.products(C.axis, C.values)[1]) @ part.gain.beta
    taken = moved[: len(made.known)]
    rows = slice(None) if C.axis is None else C.axis
    thin = bench.thin(part.id, own or 0, part.shape)
    left = np.concatenate(
        [
            values[kept] @ part.gain.beta - B[kept][:, rows] @ taken
            for values, B, kept in zip(thin, made.B, made.kept, strict=True)
        ]
    )
    return float(np.sqrt((left**2).sum() / (len(left) * (bench.n if own is None else 1))))


def _kin(bench: Bench, part: Scored, other: Scored) -> bool:
    """Whether two effects on an axis are another, and confused by their own definitions."""
    mine, its = bench.effects.get(part.id), bench.effects.get(other.id)
    if mine is None or its is None or part.axis != other.axis or part.id == other.id:
        return False
    return other.id in mine.effect.confused_with or part.id in its.effect.confused_with
