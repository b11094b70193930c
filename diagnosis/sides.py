"""The places where model and data meet: mechanism, drives, and what changes from run to run.

Each is searched by the same rules, held against the locked runs and asked what it leaves. The
drives have a file of their own, `drives.py`, and what changes from run to run, `drifts.py`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.absorbed import absorbed
from flexhex.diagnosis.answer import (
    CERTAIN,
    GAP,
    Joint,
    axis_rms,
    joint,
    lasting,
    repeat_rms,
)
from flexhex.diagnosis.blocks import JUDGED, Run, blocks
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.changed import only_changed
from flexhex.diagnosis.elsewhere import Elsewhere
from flexhex.diagnosis.guard import believed, kept_off, only, poor_axes, sentence
from flexhex.diagnosis.naming import named_of
from flexhex.diagnosis.places import without_places
from flexhex.diagnosis.regression import Columns
from flexhex.diagnosis.rounds import Round, search
from flexhex.diagnosis.scored import Found, Scored
from flexhex.diagnosis.stacked import whole
from flexhex.diagnosis.transfer import not_worse, transferred
from flexhex.diagnosis.verdict import Changed, Named

Array = NDArray[np.float64]
REST = 0.05
"""Share of what repeats on an axis that effects of several kinds may leave together."""
LARGEST_SET = 3
"""Most effects that can be said to be one of these."""
NOISIER = 1.02
"""Growth of an axis' residual beyond which an effect is noise."""


@dataclass(frozen=True)
class Side:
    """One place where model and data meet: what was found there, and what remains. payloads: those
    that no log announces."""

    held: Joint
    rounds: tuple[Round, ...]
    others: Elsewhere | None
    named: tuple[Named, ...]
    remains: tuple[int, ...]
    notes: tuple[str, ...]
    payloads: tuple[Changed, ...] = ()

    @property
    def matters(self) -> bool:
        """Whether anything was found or is left here."""
        return bool(self.named or self.remains)


class SideOf(Protocol):
    """A search: what explains the runs at one place where model and data meet."""

    def __call__(
        self,
        bench: Bench,
        judged: Sequence[Run],
        say: Callable[[str], None],
        least: float = 0.0,
        drift: Joint | None = None,
    ) -> Side: ...


def side_of(
    bench: Bench,
    judged: Sequence[Run],
    say: Callable[[str], None],
    least: float = 0.0,
    drift: Joint | None = None,
) -> Side:
    """Search, hold against the locked runs, and see what remains.

    least: smallest lag or delay that is worth a word, relative to the typical one; drift: what
    was taken off the runs before.
    """
    made = bench.made
    rounds = search(bench, say)
    notes: list[str] = []
    found = _told_apart([r.chosen for r in rounds if r.chosen], notes)
    found = _natural(bench, found, notes)
    found = without_places(bench, found, notes)
    repeats = made.noise.repeats
    held = lasting(bench, found) if repeats else believed(joint(bench, found), notes)
    held = _not_a_change(held, notes)
    pairs = zip(held.parts, held.beta, strict=True)
    worth = [part for part, beta in pairs if _size(bench, part, beta) >= least]
    held = held if len(worth) == len(held.parts) else only(held, worth)
    held = _not_noisier(held, notes)
    poor = poor_axes(made, held.residual)
    if poor:
        held = kept_off(held, poor)
        notes.append(sentence(poor))
    others = None
    if judged:
        others = Elsewhere(bench, blocks(made.base, judged, made.spacing, JUDGED), drift)
        held = transferred(not_worse(held, others, notes), others, notes)
    crowded = _approximated(held)
    if crowded:
        held = kept_off(held, crowded)
        listed = ", ".join(str(axis + 1) for axis in crowded)
        notes.append(
            f"axis {listed}: no combination of effects of the library reproduces the repeatable"
            " residual; the partial fits were discarded"
        )
    remains = _remains(held, notes)
    axes = [*remains, *crowded, *(part.axis for part in held.parts if part.axis is not None)]
    taken_on = absorbed(bench, held.effects, axes)
    if taken_on is not None:
        held = joint(bench, [*held.effects, taken_on])
        rounds.append(Round((), {}, taken_on))
        listed = ", ".join(str(axis + 1) for axis in taken_on.axes)
        notes.append(
            f"{taken_on.id} on axis {listed}: the residual could also be fitted by changed masses,"
            f" but only by more than their tolerances, so {taken_on.id} is reported"
        )
    return Side(held, tuple(rounds), others, tuple(named_of(held, rounds)), remains, tuple(notes))


def _told_apart(found: Sequence[Found], notes: list[str]) -> list[Found]:
    """Effects without those that too many others do as well as: any curve fits what is left."""
    crowd = [effect for effect in found if len(effect.rivals) >= LARGEST_SET]
    for effect in crowd:
        ids = ", ".join((effect.id, *effect.rivals))
        axes = ", ".join(str(axis + 1) for axis in effect.axes)
        where = f" on axis {axes}" if axes else ""
        notes.append(f"{ids} fit equally well{where}: these data do not distinguish them")
    return [effect for effect in found if effect not in crowd]


def _natural(bench: Bench, found: Sequence[Found], notes: list[str]) -> list[Found]:
    """Effects without those that an axis shows more often than it can have them: a family of
    curves that follows something else."""
    count = Counter((part.id, part.axis) for effect in found for part in effect.parts)
    items = bench.effects
    crowd = {key for key, n in count.items() if key[0] in items and n > items[key[0]].effect.most}
    for name, axis in sorted(crowd, key=str):
        where = "" if axis is None else f" on axis {axis + 1}"
        notes.append(
            f"{name}{where} would be needed {count[name, axis]} times: a fit of something else, not"
            " reported"
        )
    kept = [
        replace(e, parts=tuple(p for p in e.parts if (p.id, p.axis) not in crowd)) for e in found
    ]
    return [effect for effect in kept if effect.parts]


def _not_a_change(held: Joint, notes: list[str]) -> Joint:
    """Leave out effects that are a changed parameter of the model: it explains more than they do,
    and most of what they do."""
    bench = held.bench
    made = bench.made
    kept = list(held.effects)
    for effect in held.effects:
        others = [part.columns for other in kept if other is not effect for part in other.parts]
        plain = made.regression.extended(others) if others else made.regression
        mine = np.hstack([whole(made.regression, part.columns) for part in effect.parts])
        if only_changed(plain, Columns(None, mine), made.known, made.base.directions()):
            kept.remove(effect)
            notes.append(
                f"one changed parameter explains more than {effect.id}, and most of what that does:"
                " the effect is not named"
            )
    return held if len(kept) == len(held.effects) else joint(bench, kept)


def _not_noisier(held: Joint, notes: list[str]) -> Joint:
    """Keep effects off axes of which more is left with them than without: what they explain
    between passes is less than the noise that they add to each."""
    made = held.bench.made
    before = axis_rms(made.blocks, made.residual(made.regression.q))
    noisier = axis_rms(made.blocks, held.residual) > NOISIER * before
    axes = sorted(
        {part.axis for part in held.parts if part.axis is not None and noisier[part.axis]}
    )
    for i in axes:
        names = ", ".join(dict.fromkeys(part.id for part in held.parts if part.axis == i))
        notes.append(f"{names} on axis {i + 1} adds more noise than it explains and is not named")
    return kept_off(held, axes) if axes else held


def _size(bench: Bench, part: Scored, beta: Array) -> float:
    """A lag or a delay relative to the typical one; infinite for any other effect."""
    if part.id not in bench.effects or not bench.effects[part.id].effect.line:
        return np.inf
    gains = bench.effects[part.id].effect.gains
    return max(abs(float(b)) / g.typical for b, g in zip(beta, gains, strict=True))


def _open(held: Joint) -> tuple[NDArray[np.bool_], Array]:
    """Axes on which something repeats that nothing explains, and how much (n,) [N m]."""
    made = held.bench.made
    remains, certain = repeat_rms(made, held.residual)
    if not made.noise.repeats:
        return np.zeros(made.base.n, dtype=bool), remains
    return (remains > GAP * made.torque_rms) & (certain > CERTAIN), remains


def _approximated(held: Joint) -> list[int]:
    """Axes on which several effects still leave something: a family of one kind, or more than
    `REST` of what was there."""
    made = held.bench.made
    gap, remains = _open(held)
    before, _ = repeat_rms(made, made.residual(made.regression.q))
    ids = [[part.id for part in held.parts if part.axis == i] for i in range(held.bench.n)]
    family = np.array([len(set(names)) < len(names) for names in ids])
    much = np.array([len(names) > 1 for names in ids]) & (remains**2 > REST * before**2)
    return [int(i) for i in np.flatnonzero(gap & (family | much))]


def _remains(held: Joint, notes: list[str]) -> tuple[int, ...]:
    """Axes on which something repeats that nothing explains."""
    gap, remains = _open(held)
    if gap.any():
        axes = ", ".join(str(i + 1) for i in np.flatnonzero(gap))
        size = float(remains[gap].max())
        notes.append(
            f"{size:.2g} N m on axis {axes} repeats and is explained by no effect of the library"
        )
    return tuple(int(i) for i in np.flatnonzero(gap))
