"""What can be asked of the runs: read, grouped, fitted by the base model; or why nothing can."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis import logs
from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.hypotheses.own_effect import own_effects, with_own
from flexhex.diagnosis.jointfit.guard import POOR, TOGETHER, poor_axes, together
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.kinds import Kinds, axes_named, kinds_of, refuse_others, units_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.result.verdict import MEND, Diagnosis, Residual
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.runs import refuse_nothing, refuse_slow, runs_of, starts_of
from flexhex.diagnosis.runs.span import refuse_short
from flexhex.fmus.common.effects.own import OwnEffect
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
Given = Path | logs.Log
"""A log, or the file that `Options.log` says how to read."""
ONE_TRAJECTORY = "one trajectory only: no other motion can refute what is found on it"
"""A finding in the runs of a fit."""
FIGURE = re.compile(
    r"(?<![\w\[.])(?<!axis )(?<!axes )(?<!and )(?<!, )"
    r"(-?\d+(?:\.\d+(?:e[-+]?\d+)?|e[-+]?\d+|(?= (?:[A-Za-z]|%))))(?![\w\]])"
)
"""A figure of a finding: no number of an axis or of a channel."""
SAMPLES = 240e6
"""Bytes of samples that all logs together may take: beyond it stretches are left out. What is made
of them takes some five times as much."""
STILL, MOVES = 2e-3, 50.0
"""Axes that turn by less than this [rad], and all whose range is less than so many standard
deviations of their noise, excite nothing."""


@dataclass(frozen=True)
class Options:
    """base: "hexapod", "axis" for axes of unknown mass, each by itself, or another name of
    `basemodels.bases`. log: how to read. tolerance: in place of the machine file's, by the
    keys of its section. joints: of a robot's file, in the order of the axes. effects: of the
    user, `FILE.py:NAME` each, beside the library's."""

    base: str = "hexapod"
    log: logs.Options = field(default_factory=logs.Options)
    tolerance: Mapping[str, float] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunSet:
    """Runs to be explained, and those to be judged on, of n axes.

    units: of the torque of each axis. findings: what the runs had. names: files of both. coarse
    (n,): torque RMS [N m] that the angles' own error may make again in every pass. own: effects
    that the user wrote, by id. doubt: why the base model may not be this machine's.
    """

    units: tuple[str, ...]
    runs: Sequence[Run]
    judged: Sequence[Run]
    findings: tuple[str, ...]
    names: tuple[tuple[str, ...], tuple[str, ...]]
    coarse: Array
    own: Mapping[str, OwnEffect] = field(default_factory=dict)
    doubt: str = ""

    def cannot_tell(self, why: str) -> Diagnosis:
        """The answer when the runs do not hold what is needed."""
        torque = np.std(np.concatenate([run.tau.values for run in self.runs]), axis=0)
        empty = np.full(len(self.units), np.nan)
        residual = Residual(self.units, torque, empty, empty, empty, empty, empty, empty)
        return Diagnosis(
            "cannot tell", (), (), residual, (), (), (why,), self.findings, *self.names
        )


def run_set_of(
    paths: Sequence[Given],
    held_out: Sequence[Given],
    machine_file: Path | None,
    options: Options,
    settle: float | None = None,
) -> tuple[Base, RunSet, str]:
    """Runs of the logs, and why nothing can be told from them, or nothing.

    settle [s]: left out at the start of each run, instead of the base model's own.
    Raises LogError, MachineError or UsageError for what cannot be read or does not fit.
    """
    own = own_effects(options.effects)
    if not paths:
        raise LogError("no run given: name at least one log")
    share = SAMPLES / (len(paths) + len(held_out))
    reading = replace(options.log, memory=min(options.log.memory, share))
    ours, theirs = (
        [one if isinstance(one, logs.Log) else logs.read_log(one, reading) for one in given]
        for given in (paths, held_out)
    )
    for log in (*ours, *theirs):
        refuse_slow(log)
        refuse_nothing(log)
    logs.refuse_copies([*ours, *theirs])
    logs.refuse_other_joints([*ours, *theirs])
    names = tuple(log.name for log in ours), tuple(log.name for log in theirs)
    ours, theirs = logs.with_cycles(ours), logs.with_cycles(theirs)
    groups = logs.group_runs(ours)
    apart = logs.held_out(groups, logs.group_runs(theirs))
    findings = _findings([*ours, *theirs], [*groups, *apart])
    base = base_of(options.base, machine_file, ours[0], options.tolerance, options.joints)
    findings = (*getattr(base, "remarks", ()), *findings)
    own = with_own(own, [use.own for use in base.stated.uses if use.own is not None])
    for effect in own.values():
        effect.check(base.n)
    for log in [*ours, *theirs]:
        width = log["theta"].width
        refuse_others(log.name, kinds_of(log, width), kinds_of(base, base.n), "the base model")
    starts = starts_of([*ours, *theirs])
    runs, judged = runs_of(groups, base.n, starts), runs_of(apart, base.n, starts)
    if settle is not None:
        base = copy(base)
        base.settle = settle
    refuse_short(base, runs, "" if settle is None else "--settle")
    units = units_of(base, base.n, "N m")
    run_set = RunSet(units, runs, judged, findings, names, np.zeros(base.n), own)
    return base, run_set, _trouble(ours, groups, runs)


def misfit(model: Calibrated) -> str:
    """Why the runs are not those of the base model's machine, or nothing.

    If one axis of several does not fit, the model of that axis lacks something: exchanged axes or
    another machine would show on two at least, and a turned sign as a negative correlation.
    """
    if not model.base.complete:
        return ""
    # of a file that is merely wrong by many tolerances the form may still be right, and friction
    # may be most of the torque
    rubbed = with_friction(model)
    free, _ = freely(rubbed.regression, len(model.base.linear))
    poor, alike = poor_axes(rubbed, rubbed.residual(free.q)), together(model)
    strange = [int(i) for i in np.flatnonzero(alike < TOGETHER)]
    odd = sorted({*poor, *strange})
    if len(odd) == 1 < model.base.n and alike[odd[0]] > 0:
        return ""
    if poor:
        return (
            f"base model and friction leave more than {POOR:.0%} of the torque of"
            f" {axes_named(poor)}:"
            " another machine, another order or sign of the axes, or other units?"
        )
    if strange:
        return (
            f"the torque of {axes_named(strange)} does not go with what the machine file says of"
            " this motion:"
            " another machine, another order or sign of the axes?"
        )
    return ""


def _findings(read: Sequence[logs.Log], groups: Sequence[logs.RunGroup]) -> tuple[str, ...]:
    """A sentence for each finding; logs of which the same is said in other figures share one."""
    listed = [finding for log in read for finding in log.findings]
    listed += [finding for group in groups for finding in group.findings]
    alike = dict[str, list[logs.Finding]]()
    for finding in listed:
        alike.setdefault(FIGURE.sub("#", finding.text), []).append(finding)
    sentences = [
        f"{_several([finding.where for finding in same])}: {_ranged([f.text for f in same])}"
        for same in alike.values()
    ]
    if len({group.motion for group in groups}) == 1:
        sentences.append(ONE_TRAJECTORY)
    return tuple(dict.fromkeys(sentences))


def _ranged(texts: Sequence[str]) -> str:
    """Texts that differ in their figures as one, with the range of each figure that differs."""
    between, figures = FIGURE.split(texts[0])[::2], [FIGURE.findall(text) for text in texts]
    ranges = [sorted(set(own), key=float) for own in zip(*figures, strict=True)]
    shown = [own[0] if len(own) == 1 else f"{own[0]} to {own[-1]}" for own in ranges]
    return "".join(text + figure for text, figure in zip(between, [*shown, ""], strict=True))


def _several(places: Sequence[str]) -> str:
    """The place of a finding; of many the first and how many others."""
    first, *others = dict.fromkeys(places)
    return first if not others else f"{first} and {len(others)} more"


def _trouble(read: Sequence[logs.Log], groups: Sequence[logs.RunGroup], runs: Sequence[Run]) -> str:
    findings = [f for log in read for f in log.findings]
    findings += [f for group in groups for f in group.findings]
    wrong = [f for f in findings if f.kind in ("swapped", "sign", "passes")]
    if wrong:
        return f"{wrong[0]}: {MEND}, then ask again"
    silent = np.max([np.ptp(run.tau.values, axis=0) for run in runs], axis=0) == 0.0
    moved = np.max([np.ptp(run.motion.theta, axis=0) for run in runs], axis=0)
    noise = np.max([np.zeros_like(moved), *_noises(runs)], axis=0)
    kinds = kinds_of(read[0], len(moved))
    least = np.maximum([STILL if kind.turns else 0.0 for kind in kinds], MOVES * noise)
    if (moved <= least).all():
        noisy = f", less than {MOVES:g} times the noise of its angles ({_largest(noise, kinds)})"
        why = noisy if (MOVES * noise == least)[moved == moved.max()].any() else ""
        shown = _largest(moved, kinds)
        return f"no axis moves by more than {shown}{why}: a run must excite the machine"
    if (dead := np.flatnonzero(silent & (moved > least))).size:
        return (
            f"the torque of {axes_named(dead)} is the same number all the"
            " time, while the axis moves: record it, or leave the axis out of the logs and the"
            " model (--joints)"
        )
    return ""


def _largest(values: Array, kinds: Kinds) -> str:
    """The largest of the values (n,) of each kind of axis, with its unit."""
    return " and ".join(
        f"{max(v for v, other in zip(values, kinds, strict=True) if other is kind):.2g}"
        f" {kind.unit('rad')}"
        for kind in dict.fromkeys(kinds)
    )


def _noises(runs: Sequence[Run]) -> list[Array]:
    """Standard deviations (n,) of the angles' noise of each run that knows it."""
    return [run.motion.noise for run in runs if run.motion.noise is not None]
