"""What a search accepted beside a base model, and what is said of it when somebody asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere, elsewhere
from flexhex.diagnosis.jointfit.guard import left_rms
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.runs import of_other_motions
from flexhex.diagnosis.runs.span import JUDGED
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.firm import grouped
from flexhex.diagnosis.selection.select import Selection, select
from flexhex.diagnosis.selection.side import Side, side_of

Array = NDArray[np.float64]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Found:
    """A selection, with held-out runs, which decide nothing in it; drift: what was taken off the
    runs before."""

    selection: Selection
    judged: Sequence[Run]
    criteria: Criteria
    drift: Joint | None = None

    @property
    def bench(self) -> Bench:
        """Of the base model with the payloads that were found."""
        return self.selection.bench

    @cached_property
    def others(self) -> Elsewhere | None:
        """The base model on the held-out runs."""
        return self._on(self.judged)

    @cached_property
    def refuting(self) -> Elsewhere | None:
        """The same on those of them that can refute."""
        apart = _apart(self.bench, self.judged)
        return self.others if len(apart) == len(self.judged) else self._on(apart)

    @cached_property
    def side(self) -> Side:
        """What has a name, and what remains."""
        return side_of(self.selection, self.others, self.refuting, self.criteria)

    @cached_property
    def fit(self) -> Joint | None:
        """Beside all effects and parameters that the search accepted, whether they are named or
        not; none without any effect."""
        effects = self.selection.effects
        freed = self.selection.freed(self.criteria)
        return joint(self.bench, grouped(self.bench, effects), freed) if effects else None

    @property
    def freedom(self) -> int:
        """Numbers that these effects may choose."""
        return sum(e.score.hypothesis.freedom for e in self.selection.effects)

    @cached_property
    def left(self) -> Array:
        """RMS (n,) of what repeats beside all these, or as much as is worth a word [N m]."""
        fit = self.fit or joint(self.bench, ())
        return np.maximum(left_rms(fit), self.criteria.smallest_rest * self.bench.model.torque_rms)

    def _on(self, runs: Sequence[Run]) -> Elsewhere | None:
        if not runs:
            return None
        model = self.bench.model
        listed = blocks(model.base, runs, model.spacing, JUDGED)
        return elsewhere(self.bench, listed, self.drift)


def found(
    bench: Bench,
    judged: Sequence[Run],
    say: Say,
    drift: Joint | None = None,
    criteria: Criteria = USUAL,
) -> Found:
    """What explains the runs beside a base model."""
    one = len({block.run.trajectory for block in bench.model.blocks}) == 1
    if one and not _apart(bench, judged):
        # nothing will be named: one effect of each axis is enough to say what would fit
        criteria = replace(criteria, most=1)
    return Found(select(bench, criteria, say), judged, criteria, drift)


def _apart(bench: Bench, judged: Sequence[Run]) -> list[Run]:
    return of_other_motions(judged, [block.run for block in bench.model.blocks])
