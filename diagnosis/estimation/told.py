"""Parameters of a base model, fitted beside what a diagnosis found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.changes import loaded, loosened
from flexhex.diagnosis.estimation.collinear import grouped, pruned
from flexhex.diagnosis.estimation.determined import Seen
from flexhex.diagnosis.estimation.estimate import estimate
from flexhex.diagnosis.estimation.extras import GROUP as EFFECT
from flexhex.diagnosis.estimation.found import extras_of
from flexhex.diagnosis.estimation.friction import GROUP as FRICTION
from flexhex.diagnosis.estimation.stated import with_stated
from flexhex.diagnosis.estimation.structure import Combination
from flexhex.diagnosis.result.estimates import Parameter
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.runs.run import Run
from flexhex.fmus.common.effects import Effect


def parameters_of(
    base: Base, runs: Sequence[Run], found: Diagnosis, own: Mapping[str, Effect]
) -> tuple[Parameter, ...]:
    """The base model's own parameters, and in the place of those that these motions move together
    their sums; dry friction is fitted beside them where the diagnosis has found none, too. own:
    effects beside the library's, by id."""
    more = with_stated(base, extras_of(found.data(), "the diagnosis", own))
    base, _ = loosened(base, more.changed)
    runs, _ = loaded(runs, more.changed)
    estimated, out = pruned(estimate(base, runs, more)[0])
    seen, (sums, _) = Seen(estimated, out), grouped(estimated, out)
    vague = {place for one in sums for place, _ in one.terms}
    alone = [Combination(((p, 1.0),)) for p in range(len(estimated.known)) if p not in vague]
    others = {EFFECT, FRICTION, "delay"}
    ours = {p for p, known in enumerate(estimated.known) if known.group not in others}
    return tuple(seen.parameter(one) for one in (*alone, *sums) if ours & {p for p, _ in one.terms})
