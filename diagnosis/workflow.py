"""From files to an answer: read, group, calibrate, search, judge on the held-out runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.drives.drives import drives_of
from flexhex.diagnosis.estimation.told import parameters_of
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.hypotheses.own_effect import sought
from flexhex.diagnosis.jointfit.guard import (
    delayed,
    poor_axes,
)
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.mechanism import mechanism, steadily
from flexhex.diagnosis.prepare import Given, Options, RunSet, misfit, run_set_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.residuals import (
    before_of,
    levelled,
    residual_of,
    resting,
    slow,
    unmoved,
    unseen,
)
from flexhex.diagnosis.result.changed import tolerated_of
from flexhex.diagnosis.result.confidence import Confidence, confidence_of
from flexhex.diagnosis.result.laden import answered
from flexhex.diagnosis.result.maps import maps
from flexhex.diagnosis.result.negative import negative
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.runs.pairing import doubtful, mispaired
from flexhex.diagnosis.runs.runs import of_other_motions
from flexhex.diagnosis.selection.criteria import USUAL as CRITERIA
from flexhex.diagnosis.selection.decided import verdict_of
from flexhex.diagnosis.selection.select import carrying
from flexhex.diagnosis.selection.side import Side
from flexhex.diagnosis.stated import beside_the_file
from flexhex.diagnosis.strips import strips
from flexhex.numeric.memory import give_back

Array = NDArray[np.float64]
Progress = Callable[[str, int, int], None]
USUAL = Options()
__all__ = ["Options", "diagnose", "diagnose_files", "silent"]


def silent(text: str, done: int, total: int) -> None:
    """A progress that nobody watches."""


def diagnose(
    paths: Sequence[Given],
    held_out: Sequence[Given] = (),
    machine_file: Path | None = None,
    options: Options = USUAL,
    progress: Progress = silent,
    note: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Find where model and data disagree, and name what is missing.

    note: told at once what may make all that follows worthless. Raises LogError, MachineError or
    UsageError for what cannot be read or does not fit.
    """
    progress("reading", 0, 4)
    base, run_set, trouble = run_set_of(paths, held_out, machine_file, options)
    if trouble := trouble or mispaired(base, run_set.runs):
        return run_set.cannot_tell(trouble)
    diagnosis = _told(base, run_set, progress, note)
    if base.complete:
        return diagnosis
    # nobody knows them otherwise
    return replace(diagnosis, parameters=parameters_of(base, run_set.runs, diagnosis, run_set.own))


def _told(
    base: Base, run_set: RunSet, progress: Progress, note: Callable[[str], None]
) -> Diagnosis:
    """The answer for logs that hold what is needed."""
    if len(run_set.runs) == 1 and not of_other_motions(run_set.judged, run_set.runs):
        return run_set.cannot_tell(
            "one run cannot tell what its noise is: run it again, and another trajectory, or give a"
            " held-out run of another one"
            + ("; give held-out runs of the same motion as runs" if run_set.judged else "")
        )
    progress("fitting the base model", 1, 4)
    model, coarse, smoothed = fitted(base, run_set.runs)
    give_back()
    if smoothed:
        run_set = replace(run_set, findings=(smoothed, *run_set.findings), coarse=coarse)
    # accelerations are as the runs tell them only when they are smoothed for long enough
    if doubt := doubtful(model.base, run_set.runs):
        note(doubt)
        run_set = replace(run_set, findings=(doubt, *run_set.findings), doubt=doubt)
    trouble = misfit(model)
    if trouble:
        # a payload may be most of what does not fit
        known = compiled(model.base.n, sought(run_set.own), model.base.holds)
        bench = carrying(Bench(model, known))
        model, trouble = bench.model, misfit(bench.model)
    if trouble:
        return run_set.cannot_tell(trouble)
    return _searched(model, run_set, progress)


def _searched(model: Calibrated, run_set: RunSet, progress: Progress) -> Diagnosis:
    """The answer for a base model that fits the runs well enough."""
    n, judged = model.base.n, run_set.judged
    known = compiled(n, sought(run_set.own), model.base.holds)
    before, settled = mechanism(model, known, judged, lambda text: progress(text, 2, 4))
    give_back()
    model, sides = settled.fit.bench.model, [settled]
    if len(poor_axes(model, settled.fit.residual)) == n:
        return run_set.cannot_tell(settled.notes[-1])
    progress("commanded against reported torque", 3, 4)
    sides += drives_of(model, [block.run for block in model.blocks], judged)
    settled, drifts = steadily(settled, known, judged, lambda text: progress(text, 3, 4))
    model, stated = settled.fit.bench.model, bool(settled.fit.bench.model.base.stated.uses)
    if stated:
        settled = beside_the_file(settled, CRITERIA)
    sides[0] = settled
    sides += drifts
    late = delayed(settled.fit, CRITERIA.deviations, not settled.remains)
    named = [effect for side in sides for effect in side.named]
    main = next((side for side in sides if side.matters), settled)
    notes = list(dict.fromkeys(note for side in sides for note in side.notes))
    changed = settled.changed
    residual = residual_of(
        before if main is settled else before_of(main.fit.bench.model, main.others), main
    )
    told = [rest.axis - 1 for rest in main.rests]
    notes += [*slow(residual, levelled(main)), *unseen(residual, told), *resting(residual)]
    verdict = verdict_of(model, sides, named, changed, notes, run_set.coarse)
    if stated and verdict == "none":
        residual = unmoved(residual)
    if run_set.doubt and answered(settled.fit.bench.model.base, changed, run_set.runs):
        findings = tuple(text for text in run_set.findings if text != run_set.doubt)
        run_set = replace(run_set, findings=findings, doubt="")
    doubt = run_set.doubt or negative(settled.fit, CRITERIA.deviations)
    least = CRITERIA.deviations, CRITERIA.smallest_effect
    progress("done", 4, 4)
    return Diagnosis(
        verdict,
        tuple(named),
        tuple(c for c in changed if c.runs or verdict not in ("unknown", "cannot tell")),
        residual,
        main.candidates,
        maps(main.fit),
        tuple(notes),
        tuple(dict.fromkeys(filter(None, [doubt, late, *run_set.findings]))),
        *run_set.names,
        strips=strips(main),
        remains=settled.rests,
        confidence=None if doubt else _confidence(settled, verdict),
        doubt=doubt,
        tolerated=()
        if verdict in ("unknown", "cannot tell")
        else tolerated_of(settled.fit, *least),
    )


def _confidence(side: Side, verdict: str) -> Confidence | None:
    """Of runs that repeat, on trajectories of which one can predict another, by a model that
    explains most of the torque: others are not in the study."""
    model = side.fit.bench.model
    if poor_axes(model, side.fit.residual):
        return None
    trajectories = {block.run.trajectory for block in model.blocks}
    return confidence_of(verdict) if model.noise.repeats and len(trajectories) > 1 else None


def diagnose_files(
    paths: Sequence[Path],
    held_out: Sequence[Path],
    machine_file: Path | None = None,
    options: Options = USUAL,
) -> dict[str, Any]:
    """`diagnose` as the data of `--json`."""
    return diagnose(paths, held_out, machine_file, options).data()
