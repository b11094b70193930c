"""From files to parameters: estimates, what the runs determine of them, how well they fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.robot_more import tolerance_of
from flexhex.diagnosis.estimation import predicted
from flexhex.diagnosis.estimation.changes import loaded, loosened
from flexhex.diagnosis.estimation.collinear import grouped, pruned
from flexhex.diagnosis.estimation.determined import Seen
from flexhex.diagnosis.estimation.estimate import Estimated, estimate
from flexhex.diagnosis.estimation.extras import Extras
from flexhex.diagnosis.estimation.forward.simulation import simulation
from flexhex.diagnosis.estimation.records import Errors, Identified
from flexhex.diagnosis.estimation.signs import negative_values
from flexhex.diagnosis.estimation.stated import with_stated
from flexhex.diagnosis.estimation.structure import Combination, structure
from flexhex.diagnosis.estimation.unannounced import with_payload
from flexhex.diagnosis.kinds import axes_named, units_of
from flexhex.diagnosis.prepare import Given, Options, misfit, run_set_of
from flexhex.diagnosis.result.verdict import LARGE, NORMAL
from flexhex.diagnosis.runs.nominal import SURE
from flexhex.diagnosis.runs.pairing import doubtful, mispaired
from flexhex.diagnosis.runs.run import Run
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
EXACT = {"geometry": 0.0, "gravity": 0.0}
"""Tolerances of a geometry that is that of the file."""
FAR = 1000
"""Standard deviations of which more say no more."""
Progress = Callable[[str, int, int], None]


def identify(
    paths: Sequence[Given],
    held_out: Sequence[Given] = (),
    machine_file: Path | None = None,
    options: Options | None = None,
    settle: float | None = None,
    progress: Progress = lambda *_: None,
    more: Extras | None = None,
) -> Identified:
    """Parameters of a base model from runs; held_out: runs that they are tried on; more: effects
    that are fitted beside.

    settle [s]: what is left out at the start of each run, instead of the base model's own. Errors
    of geometry are fitted only where `options.tolerance` names a tolerance of them. Raises
    LogError, MachineError or UsageError for what cannot be read or does not fit.
    """
    options = options or Options()
    more = more or Extras()
    progress("reading", 0, 3)
    given = {**tolerance_of(options.base), **options.tolerance}
    placed = not given.keys().isdisjoint(EXACT)
    if placed:
        options = replace(options, tolerance={**EXACT, **given})
    base, run_set, trouble = run_set_of(paths, held_out, machine_file, options, settle)
    base = _plain(base, placed)
    if trouble := trouble or mispaired(base, run_set.runs):
        raise LogError(trouble)
    more.check(base.n)
    more = with_stated(base, more)
    progress("fitting the parameters", 1, 3)
    estimated, smoothed, said, out = _fitted(base, run_set.runs, more)
    doubt = doubtful(estimated.model.base, run_set.runs)
    progress("on held-out runs", 2, 3)
    errors = predicted.errors(estimated, estimated.model)
    judged = estimated.along(run_set.judged) if run_set.judged else None
    other = predicted.errors(estimated, judged) if judged else None
    seen, (sums, together) = Seen(estimated, out), grouped(estimated, out)
    which = structure(estimated.model.base, estimated.model.blocks)
    names = [known.name for known in estimated.known]
    late = next(i for i, k in enumerate(estimated.known) if k.group == "delay")
    shown = [i for i, k in enumerate(estimated.known) if k.group != "delay"]
    vague = {place for one in sums for place, _ in one.terms}
    progress("done", 3, 3)
    return Identified(
        options.base,
        tuple(seen.parameter(Combination(((p, 1.0),)), p in vague) for p in shown),
        tuple(seen.parameter(c) for c in (*_apart(which.combinations, vague), *sums)),
        tuple(names[place] for place in which.silent),
        units_of(base, base.n, "N m"),
        errors,
        other,
        seen.parameter(Combination(((late, 1.0),))).estimate,
        (*said, *together, *more.notes, *_notes(estimated, errors), *_nothing(estimated)),
        (*negative_values(estimated)[0], *run_set.findings, *filter(None, [smoothed])),
        *run_set.names,
        estimated,
        doubt,
        predicted.strips(estimated, judged or estimated.model, judged is not None),
        simulation(estimated, judged or estimated.model, judged is not None),
    )


def _apart(combinations: Sequence[Combination], vague: set[int]) -> list[Combination]:
    """Those that have a value without others."""
    return [one for one in combinations if len(one.terms) > 1 or one.terms[0][0] not in vague]


def _fitted(
    base: Base, runs: Sequence[Run], more: Extras
) -> tuple[Estimated, str, list[str], list[str]]:
    """The fit with what a diagnosis found and payloads that nothing announces; what was done about
    noise of the angles; what was found on the way; and names of what is left out."""
    base, freed = loosened(base, more.changed)
    runs, carried = loaded(runs, more.changed)
    estimated, smoothed = estimate(base, runs, more)
    if trouble := misfit(estimated.model):
        raise LogError(trouble)
    if not any(change.runs for change in more.changed):
        estimated, text = with_payload(base, runs, estimated)
        carried = [text] if text else []
    estimated, out = pruned(estimated)
    return estimated, smoothed, [*carried, *freed], out


def _plain(base: Base, placed: bool) -> Base:
    """The base model with the geometry of its file, unless a tolerance of it was given."""
    plain = copy(base)
    if not placed:
        plain.geometry = None
    return plain


def _attenuation(estimated: Estimated, deviation: Array) -> list[str]:
    """Parameters that noise of the angles made smaller by a good part of their deviation."""
    back, values = np.abs(estimated.attenuated), np.abs(estimated.values)
    shares = {
        known.name: float(back[k] / values[k])
        for k, known in enumerate(estimated.known)
        if known.group != "delay" and deviation[k] / 2 < back[k] < values[k]
    }
    if not shares:
        return []
    listed = ", ".join(f"{name} by {share:.1%}" for name, share in shares.items())
    return [
        f"noise or steps of the angles made what goes with accelerations too small, {listed}: it is"
        " given back, and their intervals are wider by as much; finer angles, or measured rates or"
        " accelerations, tell more"
    ]


def _nothing(estimated: Estimated) -> list[str]:
    """Effects that are fitted beside and come out as none."""
    deviation = np.sqrt(np.maximum(np.diag(estimated.covariance), 0.0))
    sure = dict(zip((k.name for k in estimated.known), estimated.values / np.maximum(
        NORMAL * deviation, np.finfo(float).tiny), strict=True))  # fmt: skip
    names = [
        f"{one.effect.id} of axis {one.axis + 1}"
        for one in estimated.extras.listed
        if all(abs(sure.get(one.parameter(g.name), np.inf)) < 1 for g in one.effect.gains)
    ]
    return [f"{', '.join(names)}: these runs show nothing of it"] if names else []


def _notes(estimated: Estimated, errors: Errors) -> list[str]:
    trajectories = {block.run.trajectory for block in estimated.model.blocks}
    asked = "`flexhex diagnose` says what"
    if len(trajectories) == 1:
        asked += ", given runs of another trajectory"
    deviation = np.maximum(np.sqrt(np.diag(estimated.covariance)), np.finfo(float).tiny)
    off = np.abs(estimated.free - estimated.values) / deviation
    against = {name: float(max(off[k] for k in own)) for name, own in estimated.wrong.items()}
    _, rubbing = negative_values(estimated)
    sure = [name for name, size in against.items() if size > SURE and name not in rubbing]
    within = [name for name, size in against.items() if size <= SURE]
    notes = _attenuation(estimated, deviation)
    if sure:
        most = max(against[name] for name in sure)
        far = f"{most:.1f}" if most < FAR else f"more than {FAR}"
        notes.append(
            f"{', '.join(sure)}: the runs alone ask for values that no machine has, up to"
            f" {far} standard deviations away; these are the"
            f" nearest that one can have. Something else is missing: {asked}"
        )
    if within:
        notes.append(
            f"{', '.join(within)}: the best fit lies at values that no machine has, within the"
            " noise; these are the nearest that one can have"
        )
    there = {known.name for known in estimated.known}
    same = [i for i in range(estimated.model.base.n) if f"o[{i + 1}]" not in there]
    if same:
        notes.append(
            f"an offset of {axes_named(same)} acts as parameters of the base model do, on these"
            " motions: it is not fitted beside them"
        )
    poor = [i for i, left in enumerate(errors.fitted) if left > LARGE]
    if poor:
        notes.append(
            f"more than {LARGE:.0%} of the torque of {axes_named(poor)} is left: the intervals"
            f" hold for this model, which lacks something: {asked}"
        )
    return notes
