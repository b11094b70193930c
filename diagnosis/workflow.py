"""From files to an answer: read, group, calibrate, search, judge on the locked runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis import logs
from diagnosis.answer import (
    Elsewhere,
    Joint,
    axis_rms,
    repeat_rms,
)
from diagnosis.base import Base
from diagnosis.bases import base_of
from diagnosis.blocks import Run, blocks, spacing_for
from diagnosis.calibrate import Calibrated
from diagnosis.changed import changes
from diagnosis.compiled import compiled
from diagnosis.confusion import confusion
from diagnosis.fit import calibrate
from diagnosis.guard import POOR, poor_axes, strange_axes
from diagnosis.maps import maps
from diagnosis.naming import tried_of
from diagnosis.noise import measured
from diagnosis.runs import runs_of
from diagnosis.sides import Side, drifts_of, drives_of, side_of
from diagnosis.verdict import Changed, Diagnosis, Gap, Named
from fmus.common.errors import LogError

Array = NDArray[np.float64]
RANGE = (0.4, 2.5)
"""Smallest and largest change of a parameter that is believed, relative."""
MOST_ROWS = 16_000
"""Instants of all runs together; more is thinned."""
STILL = 2e-3
"""Axes that move less than this [rad] excite nothing."""
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Options:
    """base: "hexapod", "axis" for axes of unknown mass, each by itself, or another name of
    `diagnosis.bases`. log: how to read.

    confidence: trials for each row of the confusion table, 0: none.
    """

    base: str = "hexapod"
    log: logs.Options = field(default_factory=logs.Options)
    confidence: int = 20


def silent(text: str, done: int, total: int) -> None:
    """A progress that nobody watches."""


def diagnose(
    paths: Sequence[Path],
    locked: Sequence[Path] = (),
    machine_file: Path | None = None,
    options: Options = Options(),
    progress: Progress = silent,
) -> Diagnosis:
    """Find where model and data disagree, and name what is missing.

    Raises LogError, MachineError or UsageError for what cannot be read or does not fit.
    """
    if not paths:
        raise LogError("no run given: name at least one log")
    progress("reading", 0, 5)
    ours = [logs.read_log(path, options.log) for path in paths]
    theirs = [logs.read_log(path, options.log) for path in locked]
    logs.refuse_copies([*ours, *theirs])
    groups, apart = logs.group_runs(ours), logs.group_runs(theirs)
    findings = _findings([*ours, *theirs], [*groups, *apart])
    base = base_of(options.base, machine_file, ours[0])
    runs, judged = runs_of(groups, base.n), runs_of(apart, base.n)
    names = tuple(log.name for log in ours), tuple(log.name for log in theirs)
    trouble = _trouble(ours, runs)
    if trouble:
        return _cannot_tell(base, runs, trouble, findings, names)
    progress("fitting the base model", 1, 5)
    spacing = spacing_for(base, runs, MOST_ROWS)
    # logs in other units than they say end in numbers beyond all bounds, and are told of below
    with np.errstate(over="ignore", invalid="ignore"):
        made = calibrate(base, blocks(base, runs, spacing))
    poor = poor_axes(made, made.residual(made.regression.q)) if base.complete else []
    if poor:
        axes = ", ".join(str(i + 1) for i in poor)
        text = (
            f"the base model leaves more than {POOR:.0%} of the torque of axis {axes} unexplained:"
            " another machine, another order or sign of the axes, or other units?"
        )
        return _cannot_tell(base, runs, text, findings, names)
    strange = strange_axes(made) if base.complete else []
    if strange:
        axes = ", ".join(str(i + 1) for i in strange)
        text = (
            f"the torque of axis {axes} does not go with what the machine file says of this motion:"
            " another machine, another order or sign of the axes?"
        )
        return _cannot_tell(base, runs, text, findings, names)
    return _searched(made, runs, judged, options, progress, findings, names)


def _searched(
    made: Calibrated,
    runs: Sequence[Run],
    judged: Sequence[Run],
    options: Options,
    progress: Progress,
    findings: tuple[str, ...],
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> Diagnosis:
    """The answer for a base model that fits the runs well enough."""
    n = made.base.n
    known = compiled(n, without=made.base.holds)
    sides = [side_of(made, known, judged, lambda text: progress(text, 2, 5))]
    poor = poor_axes(made, sides[0].held.residual)
    if len(poor) == n:
        why = "; ".join(sides[0].notes)
        return _cannot_tell(made.base, runs, why, findings, names)
    progress("commanded against reported torque", 3, 5)
    sides += drives_of(made, runs, judged)
    sides += drifts_of(sides[0], judged)
    named = [effect for side in sides for effect in side.named]
    main = next((side for side in sides if side.matters), sides[0])
    notes = list(dict.fromkeys(note for side in sides for note in side.notes))
    extended = made.regression
    if sides[0].held.parts:
        extended = extended.extended([part.columns for part in sides[0].held.parts])
    changed = _plausible(changes(extended, made.known, made.base.directions()), named)
    verdict = _verdict(made, sides, named, changed, notes)
    progress("measuring confidence", 4, 5)
    if named and options.confidence:
        named = [
            confusion(side.held, effect, options.confidence)
            for side in sides
            for effect in side.named
        ]
    progress("done", 5, 5)
    return Diagnosis(
        verdict,
        tuple(named),
        () if verdict == "unknown" else tuple(changed),
        _gap(main.held, main.others),
        tried_of(main.rounds),
        maps(main.held),
        tuple(notes),
        findings,
        *names,
    )


def _plausible(changed: Sequence[Changed], named: Sequence[Named]) -> list[Changed]:
    """Changes that no effect found on the same axis could have taken part in.

    An effect that acts through the inertias leaves none of them to be trusted.
    """
    axes = {axis for effect in named for axis in effect.axes}
    own = tuple(f"[{axis}" for axis in axes)
    apart = [c for c in changed if not any(mark in c.parameter for mark in own)]
    return [c for c in apart if not named or _possible(c)]


def _possible(change: Changed) -> bool:
    """Whether a parameter could have such a value: not half or twice what it was."""
    value, nominal = change.estimate.value, change.nominal
    small = abs(nominal) < 1e-9
    return small or (RANGE[0] < value / nominal < RANGE[1])


def diagnose_files(
    paths: Sequence[Path],
    locked: Sequence[Path],
    machine_file: Path | None = None,
    options: Options = Options(confidence=0),
) -> dict[str, Any]:
    """`diagnose` as the data of `--json`."""
    return diagnose(paths, locked, machine_file, options).data()


def _findings(read: Sequence[logs.Log], groups: Sequence[logs.RunGroup]) -> tuple[str, ...]:
    listed = [finding for log in read for finding in log.findings]
    listed += [finding for group in groups for finding in group.findings]
    return tuple(dict.fromkeys(str(finding) for finding in listed))


def _trouble(read: Sequence[logs.Log], runs: Sequence[Run]) -> str:
    """Why nothing can be told, or nothing."""
    swapped = [f for log in read for f in log.findings if f.kind in ("swapped", "sign")]
    if swapped:
        return f"{swapped[0]}: mend the log, then ask again"
    moved = np.max([np.ptp(run.motion.theta, axis=0) for run in runs], axis=0)
    if (moved < STILL).all():
        return f"no axis moves by more than {moved.max():.2g} rad: a run must excite the machine"
    return ""


def _gap(held: Joint, others: Elsewhere | None) -> Gap:
    made = held.bench.made
    plain, bare = made.regression.q, np.zeros(len(made.known))
    before, _ = repeat_rms(made, made.residual(plain))
    after, _ = repeat_rms(made, held.residual)
    floor = np.full(made.base.n, np.nan)
    if made.noise.repeats:
        floor = measured(made.blocks, held.residual).floor
    judged: dict[str, Array] = {}
    if others is not None:
        left = others.residual(held.parts, held.beta, held.q)
        own = measured(others.blocks, left)
        judged = {
            "nominal": axis_rms(others.blocks, others.residual((), (), bare)),
            "before": axis_rms(others.blocks, others.residual((), (), plain)),
            "after": axis_rms(others.blocks, left),
        } | ({"floor": own.floor} if own.repeats else {})
    listed = (made.residual(bare), made.residual(plain), held.residual)
    one, two, three = (axis_rms(made.blocks, values) for values in listed)
    return Gap("N m", made.torque_rms, one, two, three, floor, before, after, judged)


def _verdict(
    made: Calibrated,
    sides: Sequence[Side],
    named: Sequence[Named],
    changed: Sequence[Changed],
    notes: list[str],
) -> str:
    if named:
        return "set" if any(effect.rivals for effect in named) else "named"
    if not made.noise.repeats:
        notes.append("no trajectory was run twice: what does not repeat cannot be set apart")
        return "changed" if changed else "cannot tell"
    if any(side.remains for side in sides):
        return "unknown"
    if not all(_possible(change) for change in changed):
        notes.append(
            "only impossible parameters could explain the runs: something is missing that the"
            " library does not tell from them"
        )
        return "unknown"
    return "changed" if changed else "none"


def _cannot_tell(
    base: Base,
    runs: Sequence[Run],
    why: str,
    findings: tuple[str, ...],
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> Diagnosis:
    torque = np.std(np.concatenate([run.tau.values for run in runs]), axis=0)
    empty = np.full(base.n, np.nan)
    gap = Gap("N m", torque, empty, empty, empty, empty, empty, empty)
    return Diagnosis("cannot tell", (), (), gap, (), (), (why,), findings, *names)
