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

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.rivals import NEAR, clarified, rivals
from flexhex.diagnosis.scored import Found, Scored, allowed, leaders
from flexhex.diagnosis.sizes import is_large, unexplained, worth
from flexhex.diagnosis.stacked import whole

Array = NDArray[np.float64]
MOST, ROUNDS = 4, 8
"""Most effects of a diagnosis; an effect may come again with another shape."""
LEVEL = 0.01
"""False alarms that all candidates together may raise."""
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
    places = [p for p in (None, *range(bench.n)) if worth(bench, energy, p)]
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
        parts = [p for p in found.parts if is_large(bench, regression, p, energy, first, known)]
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


def _count(bench: Bench) -> int:
    shapes = sum(len(item.shapes) for item in bench.effects.values())
    return bench.n * shapes + len(bench.whole)


def _energy(energy: Array, parts: Sequence[Scored]) -> float:
    axes = [part.axis for part in parts]
    return float(energy.sum() if None in axes else sum(energy[a] for a in axes if a is not None))
