"""From files to an answer: read, group, calibrate, search, judge on the locked runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis import logs
from diagnosis.answer import (
    CERTAIN,
    GAP,
    Elsewhere,
    Joint,
    axis_rms,
    joint,
    lasting,
    repeat_rms,
)
from diagnosis.base import Base
from diagnosis.bases import base_of
from diagnosis.blocks import JUDGED, Run, blocks, spacing_for
from diagnosis.calibrate import Calibrated, calibrate
from diagnosis.candidates import Bench, Compiled, compiled
from diagnosis.changed import changes
from diagnosis.confusion import confusion
from diagnosis.guard import POOR, believed, kept_off, only, poor_axes, sentence
from diagnosis.maps import maps
from diagnosis.naming import named_of, tried_of
from diagnosis.noise import measured
from diagnosis.path import PathBase, common_lag, driven
from diagnosis.rounds import Round, Scored, one_round, search, unexplained
from diagnosis.runs import runs_of
from diagnosis.verdict import Changed, Diagnosis, Gap, Named
from fmus.common.effects import library
from fmus.common.errors import LogError

Array = NDArray[np.float64]
DRIFTS = ("thermal_drift", "offset_drift")
"""Effects that go on from run to run."""
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
    made = calibrate(base, blocks(base, runs, spacing))
    poor = poor_axes(made, made.residual(made.regression.q)) if base.complete else []
    if poor:
        axes = ", ".join(str(i + 1) for i in poor)
        text = (
            f"the base model leaves more than {POOR:.0%} of the torque of axis {axes} unexplained:"
            " another machine, another order or sign of the axes, or other units?"
        )
        return _cannot_tell(base, runs, text, findings, names)
    return _searched(made, runs, judged, options, progress, findings, names)


@dataclass(frozen=True)
class _Side:
    """One place where model and data meet: what was found there, and what remains."""

    held: Joint
    rounds: tuple[Round, ...]
    others: Elsewhere | None
    named: tuple[Named, ...]
    remains: tuple[int, ...]
    notes: tuple[str, ...]

    @property
    def matters(self) -> bool:
        """Whether anything was found or is left here."""
        return bool(self.named or self.remains)


def _side(
    made: Calibrated,
    effects: Sequence[Compiled],
    judged: Sequence[Run],
    say: Callable[[str], None],
) -> _Side:
    """Search, hold against the locked runs, and see what remains."""
    bench = Bench(made, effects)
    rounds = search(bench, say)
    found = [r.chosen for r in rounds if r.chosen]
    notes: list[str] = []
    repeats = made.noise.repeats
    held = lasting(bench, found) if repeats else believed(joint(bench, found), notes)
    poor = poor_axes(made, held.residual)
    if poor:
        held = kept_off(held, poor)
        notes.append(sentence(poor))
    others = None
    if judged:
        others = Elsewhere(bench, blocks(made.base, judged, made.spacing, JUDGED))
        held = _not_worse(held, others, notes)
    crowded = _approximated(held)
    if crowded:
        held = kept_off(held, crowded)
        listed = ", ".join(str(axis + 1) for axis in crowded)
        notes.append(
            f"several effects together come near what repeats on axis {listed}, but leave some of"
            " it: they only imitate something else and are not named"
        )
    remains = _remains(held, notes)
    return _Side(held, tuple(rounds), others, tuple(named_of(held, rounds)), remains, tuple(notes))


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
    sides = [_side(made, known, judged, lambda text: progress(text, 2, 5))]
    poor = poor_axes(made, sides[0].held.residual)
    if len(poor) == n:
        why = "; ".join(sides[0].notes)
        return _cannot_tell(made.base, runs, why, findings, names)
    progress("commanded against reported torque", 3, 5)
    sides += _drives(made, runs, judged)
    sides += _drifts(sides[0], judged)
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


def _drives(made: Calibrated, runs: Sequence[Run], judged: Sequence[Run]) -> list[_Side]:
    """The same between commanded and reported torque, where logs have both."""
    lag, base = common_lag(runs), made.base
    ours = driven(runs, lag)
    if not ours:
        return []
    path = PathBase(base.n, base.window, made.spacing, base.settle)
    blocked = blocks(path, ours, made.spacing)
    there = calibrate(path, blocked)
    known = {name: e for name, e in library().items() if e.acts_on == "drive"}
    side = _side(there, compiled(base.n, known), driven(judged, lag), lambda text: None)
    where = "between commanded and reported torque: "
    return [replace(side, notes=tuple(where + note for note in side.notes))]


def _drifts(first: _Side, judged: Sequence[Run]) -> list[_Side]:
    """What changes from run to run, and so drops out between passes.

    Not asked where something repeats that nothing explains: it would be taken for a drift.
    """
    made = replace(first.held.bench.made, between=False)
    if not made.noise.repeats or first.remains:
        return []
    known = {name: library()[name] for name in DRIFTS}
    bench = Bench(made, compiled(made.base.n, known), across=True)
    regression = made.regression
    if first.held.parts:
        regression = regression.extended([part.columns for part in first.held.parts])
    found = one_round(bench, regression, unexplained(made, regression))
    if found.chosen is None:
        return []
    held, notes = joint(bench, [found.chosen]), list[str]()
    others = None
    if judged:
        others = Elsewhere(bench, blocks(made.base, judged, made.spacing))
        held = _not_worse(held, others, notes)
    return [_Side(held, (found,), others, tuple(named_of(held, [found])), (), tuple(notes))]


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


def _not_worse(held: Joint, others: Elsewhere, notes: list[str]) -> Joint:
    """Withdraw effects, axis by axis, that make the locked runs worse."""
    kept = held.parts
    while kept:
        whole = others.squares(kept)
        falls = []
        for part in kept:
            rest = others.squares([p for p in kept if p is not part])
            axes = slice(None) if part.axis is None else part.axis
            falls.append(float(np.sum(rest[axes] - whole[axes])))
        worst = int(np.argmin(falls))
        if falls[worst] > 0:
            break
        part = kept.pop(worst)
        where = "" if part.axis is None else f" on axis {part.axis + 1}"
        notes.append(f"{part.id}{where} was withdrawn: it makes the locked runs worse")
    return held if len(kept) == len(held.parts) else only(held, kept)


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
        judged = {
            "nominal": axis_rms(others.blocks, others.residual((), (), bare)),
            "before": axis_rms(others.blocks, others.residual((), (), plain)),
            "after": axis_rms(others.blocks, others.residual(held.parts, held.beta, held.q)),
        }
    listed = (made.residual(bare), made.residual(plain), held.residual)
    one, two, three = (axis_rms(made.blocks, values) for values in listed)
    return Gap("N m", made.torque_rms, one, two, three, floor, before, after, judged)


def _open(held: Joint) -> tuple[NDArray[np.bool_], Array]:
    """Axes on which something repeats that nothing explains, and how much (n,) [N m]."""
    made = held.bench.made
    remains, certain = repeat_rms(made, held.residual)
    if not made.noise.repeats:
        return np.zeros(made.base.n, dtype=bool), remains
    return (remains > GAP * made.torque_rms) & (certain > CERTAIN), remains


def _approximated(held: Joint) -> list[int]:
    """Axes with two effects or more that still leave something behind."""
    gap, _ = _open(held)
    count = [sum(part.axis == i for part in held.parts) for i in range(held.bench.n)]
    return [i for i in range(held.bench.n) if gap[i] and count[i] > 1]


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


def _verdict(
    made: Calibrated,
    sides: Sequence[_Side],
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
