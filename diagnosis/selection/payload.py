"""A payload that came or went between runs: which runs had it, and what it predicts.

Which runs: `levels_of` says it, before anything is scored; in how many ways they could have been
parted counts against it.

Passes with and without the payload are no repeats of one another: products between them would take
the payload for noise. It is scored in another likelihood of the same runs, the one that they have
once it is accepted: the base model fitted anew, passes paired with passes of the same load alone,
the noise measured between those. What the payload adds to the log density of a left-out trajectory
is the difference between this likelihood with its columns and without them. Where no pass has
another one of its load the products are those within passes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.fit import recalibrated
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.payloads import GROUP
from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.generic_scores import generic_score
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import ColumnsByAxis, Payload
from flexhex.diagnosis.selection.levels import Levels, choices, levels_of
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score, effect_term
from flexhex.diagnosis.selection.unnamed import nameless

MASSIVE = ("kg", "kg m2")
"""Units of parameters that no payload makes smaller: the first one that the base model has."""


def payload_score(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> Score | None:
    """A payload on some of the runs, on left-out folds; None where runs do not fall into
    levels."""
    levels = levels_of(moments, criteria)
    if levels is None:
        return None
    bench = _loaded(hypotheses, levels)
    payloads = bench.model.loads[-int(levels.max()) :]
    count = len(payloads) * len(bench.model.base.payload)
    without, columns = _apart(Rows.of(bench.model), count)
    plain = _with_known(Moments(without), Hypotheses(bench, without), known, criteria)
    # a coefficient of one is the tolerance of a payload's parameter
    score = generic_score(plain, [nameless(None, GROUP, columns, (np.eye(count),))], (1.0,))
    which = np.unique([b.run.trajectory for b in bench.model.blocks], return_inverse=True)[1]
    return replace(score, hypothesis=Payload(bench, count, choices(levels, which)))


def _loaded(hypotheses: Hypotheses, levels: Levels) -> Bench:
    """The base model fitted to runs of several levels, each but the lightest a payload; the last
    one is kept."""
    bench, benches = hypotheses.bench, hypotheses.loaded
    key = tuple(int(level) for level in levels)
    if key not in benches:
        model = _calibrated(bench.model, levels)
        load = model.loads[-1]
        deltas = zip(load.known, model.fitted.loads[load.name], strict=True)
        sized = [(k.unit, delta / k.tolerance) for k, delta in deltas if k.tolerance]
        unit = next(unit for unit in MASSIVE if any(unit == own for own, _ in sized))
        if sum(size for own, size in sized if own == unit) < 0:
            model = _calibrated(bench.model, _turned(levels, model))
        model.forget()
        benches.clear()
        benches[key] = bench.beside(model)
    return benches[key]


def _turned(levels: Levels, model: Calibrated) -> Levels:
    """The heaviest as the lightest, among runs that carried the same before."""
    bits = len({load.bit for load in model.loads} - {None}) - int(levels.max())
    before = np.array([block.run.loads & (1 << bits) - 1 for block in model.blocks])
    return np.where(before == before[levels > 0][0], levels.max() - levels, levels)


def _calibrated(model: Calibrated, levels: Levels) -> Calibrated:
    bit = max(block.run.loads for block in model.blocks).bit_length()
    blocks = [
        replace(b, run=replace(b.run, loads=b.run.loads | (1 << bit + level - 1 if level else 0)))
        for b, level in zip(model.blocks, levels.tolist(), strict=True)
    ]
    return recalibrated(model, blocks)


def _apart(rows: Rows, count: int) -> tuple[Rows, ColumnsByAxis]:
    """Rows without the last `count` columns of the base model, and these."""
    kept, own = np.arange(rows.nb - count), rows.nb - count + np.arange(count)
    prior, doubt = rows.prior[:-count], rows.doubt[:-count]
    firm = rows.firm[:-count, :-count]
    fewer, white_B = rows.B.only(kept), rows.white_B.only(kept)
    without = replace(rows, B=fewer, white_B=white_B, prior=prior, doubt=doubt, firm=firm)
    raw, white = ({i: B.at(i, own) for i in range(rows.n)} for B in (rows.B, rows.white_B))
    return without, ColumnsByAxis(raw, white)


def _with_known(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> Moments:
    """The model with what was accepted, in these rows."""
    for score in known:
        if isinstance(score.hypothesis, ChangedParameter):
            moments = moments.loosened(score.hypothesis.places, criteria.loose**-2.0)
        else:
            moments = moments.extended(effect_term(moments, hypotheses, score))
    return moments
