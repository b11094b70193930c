"""The model with what a diagnosis found: FMUs built anew, held-out runs replayed, the loop closed.

OUT/machine.toml          the extended machine file
OUT/fmus, OUT/hexapod.ssp what it builds
OUT/before                the same for the machine file as it was
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.loops import Model, Tracking, closed_loops
from flexhex.diagnose.physical import below, physical
from flexhex.diagnose.replay import replay
from flexhex.diagnosis.estimation.identify import TOLERANCE, Fit, fit
from flexhex.diagnosis.logs import Log, Options, read_log
from flexhex.diagnosis.machine_files.extend import extend
from flexhex.diagnosis.result.verdict import WORSE, Diagnosis, Named
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.builder import Builder

Array = NDArray[np.float64]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Residuals:
    """Residual of one simulated run (n,) [N m]: the model as it was, and extended."""

    before: Array
    after: Array


@dataclass(frozen=True)
class Rebuilt:
    """What was built, and how it does beside the model as it was.

    machine_file: the extended one; left_out: what it cannot hold; withdrawn: ids of effects that
    made a held-out run worse; residuals by held-out run; loops by `model` (on the extended plant: a
    prediction) and `machine` (on machine.fmu), each as (before, after); notes for the reader.
    """

    builder: Builder
    machine_file: Path
    left_out: tuple[str, ...]
    withdrawn: tuple[str, ...]
    residuals: Mapping[str, Residuals]
    loops: Mapping[str, tuple[Tracking, Tracking]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def data(self) -> dict[str, Any]:
        """For `Diagnosis.shown` and `--json`."""
        return {
            "machine": str(self.machine_file),
            "left_out": list(self.left_out),
            "withdrawn": list(self.withdrawn),
            "simulation_residual": {
                name: {"unit": "N m", "before": list(g.before), "after": list(g.after)}
                for name, g in self.residuals.items()
            },
            "closed_loop": {
                name: {"before": asdict(before), "after": asdict(after), "unit": "urad, N m"}
                for name, (before, after) in self.loops.items()
            },
            "notes": list(self.notes),
        }


def rebuild(
    machine_file: Path,
    diagnosis: Diagnosis,
    out: Path,
    runs: Sequence[Path] = (),
    held_out: Sequence[Path] = (),
    *,
    options: Options | None = None,
    seconds: float = 20.0,
    loops: bool = True,
    say: Say = lambda text: None,
) -> Rebuilt:
    """Extend, build, replay the held-out runs, withdraw what makes one worse, close the loop.

    runs: what p is fitted to, for both models; seconds: judged time of the closed loops. Raises
    MachineError, LogError or BuildError for what cannot be read or built.
    """
    ours = [read_log(path, options) for path in runs]
    theirs = [read_log(path, options) for path in held_out]
    notes: list[str] = []
    say("building the model as it was")
    before = _side(machine_file, out / "before", ours, notes, say)
    target, withdrawn = out / "machine.toml", list[str]()
    while True:
        extended = extend(machine_file, diagnosis, target)
        say("building the extended model")
        after = _side(target, out, ours, notes, say)
        say("simulating the held-out runs")
        residuals = {log.name: _residuals(log, *_alike(before, after)) for log in theirs}
        worst = _culprit(machine_file, diagnosis, residuals, theirs, ours, out, say)
        if worst is None:
            break
        withdrawn.append(worst.id)
        notes.append(f"{worst.id} was withdrawn: it makes the simulation of a held-out run worse")
        kept = tuple(effect for effect in diagnosis.effects if effect is not worst)
        diagnosis = replace(diagnosis, effects=kept)
    closed = closed_loops(*_alike(before, after), seconds, say) if loops else {}
    lists = extended.left_out, tuple(withdrawn), residuals, closed, tuple(dict.fromkeys(notes))
    return Rebuilt(after.builder, target, *lists)


def _side(machine_file: Path, out: Path, logs: Sequence[Log], notes: list[str], say: Say) -> Model:
    builder = Builder(machine_file, out, say)
    builder.systems()
    machine, fitted = builder.machine, _fit(builder.machine, logs, notes)
    return Model(builder, base_parameters(machine)) if fitted is None else _side_of(builder, fitted)


def _alike(before: Model, after: Model) -> tuple[Model, Model]:
    """Both models with fitted parameters, or both with those of their files: a fit of one alone
    would decide for it."""
    if (before.std is None) == (after.std is None):
        return before, after
    plain = [Model(s.builder, base_parameters(s.builder.machine)) for s in (before, after)]
    return plain[0], plain[1]


def _side_of(builder: Builder, fitted: Fit) -> Model:
    return Model(builder, fitted.p, fitted.std)


def _fit(machine: Machine, logs: Sequence[Log], notes: list[str]) -> Fit | None:
    if not logs:
        return None
    try:
        fitted = fit(machine, logs, tolerance=TOLERANCE)
    except LogError as error:
        notes.append(f"parameters stay those of the machine file: {error}")
        return None
    notes.extend(fitted.warnings)
    if negative := below(machine, fitted.p):
        notes.append(f"simulated with zero, as the fit has it negative: {', '.join(negative)}")
    return physical(machine, fitted)


def _residuals(log: Log, before: Model, after: Model) -> Residuals:
    with ThreadPoolExecutor(2) as pool:
        jobs = [pool.submit(_residual_rms, log, side) for side in (before, after)]
        return Residuals(*(job.result() for job in jobs))


def _residual_rms(log: Log, side: Model) -> Array:
    return replay(side.builder.out / "fmus", side.builder.machine, side.p, log).rms


def _culprit(
    machine_file: Path,
    diagnosis: Diagnosis,
    residuals: Mapping[str, Residuals],
    theirs: Sequence[Log],
    ours: Sequence[Log],
    out: Path,
    say: Say,
) -> Named | None:
    """The effect without which a held-out run that became worse on its axes is best."""
    suspects = [
        effect
        for effect in diagnosis.effects
        if any(_worse(one.before, one.after, effect) for one in residuals.values())
    ]
    if len(suspects) < 2:
        return suspects[0] if suspects else None
    least: tuple[float, Named] | None = None
    for effect in suspects:
        say(f"the model without {effect.id}")
        rest = replace(diagnosis, effects=tuple(e for e in diagnosis.effects if e is not effect))
        folder = out / "without" / effect.id
        path = extend(machine_file, rest, folder / "machine.toml").path
        side = _side(path, folder, ours, [], say)
        total = math.fsum(float((_residual_rms(log, side) ** 2).sum()) for log in theirs)
        if least is None or total < least[0]:
            least = total, effect
    return least[1] if least else None


def _worse(before: Array, after: Array, effect: Named) -> bool:
    axes = [axis - 1 for axis in effect.axes] or list(range(len(before)))
    return float(np.linalg.norm(after[axes])) > WORSE * float(np.linalg.norm(before[axes]))
