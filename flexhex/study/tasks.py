"""The runs of a Monte Carlo study (`flexhex study`): listed, carried out, reduced to figures.

Only figures are kept. Every finished run is one JSON line; its key is a hash of the .ssp, all
parameters and the duration, so nothing runs twice.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexhex.fmus.common.archive import read_bytes
from flexhex.fmus.common.errors import InterfaceError, UsageError, unreadable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, truth_file
from flexhex.fmus.machine.truth import Truth, load_truth
from flexhex.fmus.plant.interface import parameters as plant_parameters
from flexhex.simulation.cases import SETTLE
from flexhex.simulation.metrics import rms
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from flexhex.study.draws import BUILT, StudyPlan, Values, draw, start_values
from flexhex.study.store import Scored, Store

CASES = ("fixed", "adaptive")
SIGNALS = ("feedback.e", "feedback.tau_fb", "feedback.fault", "plant.fault")


@dataclass(frozen=True)
class Task:
    """One run of one case: parameters go over what the .ssp says; drawn is what is shown."""

    case: str
    number: int
    ssp: Path
    duration: float
    parameters: Values
    drawn: Mapping[str, float]
    key: str


@dataclass(frozen=True)
class StudyResult:
    """Figures of a study by key, in the order of the tasks; failed: errors by key; kept: how many
    figures were computed before."""

    plan: StudyPlan
    tasks: tuple[Task, ...]
    scored: Mapping[str, Scored]
    failed: Mapping[str, str] = field(default_factory=dict)
    kept: int = 0

    def of(self, case: str) -> list[Scored]:
        """Finished runs of a case, by number."""
        return [self.scored[t.key] for t in self.tasks if t.case == case and t.key in self.scored]

    def pairs(self) -> list[tuple[Scored, Scored]]:
        """Fixed and adaptive figures of the same draw, where both are there."""
        adaptive = {s.number: s for s in self.of("adaptive")}
        return [(s, adaptive[s.number]) for s in self.of("fixed") if s.number in adaptive]


Pool = Callable[[Sequence[Task]], Iterator[tuple[Task, Scored | str]]]


def tasks(plan: StudyPlan, machine_file: Path, out: Path) -> tuple[Task, ...]:
    """All runs of a plan on the systems that `flexhex run` left in `out/cases`, both cases of
    a draw one after the other. InterfaceError when one is missing, UsageError when it is of another
    machine."""
    plan.check()
    systems = {case: out / "cases" / case / "hexapod.ssp" for case in CASES}
    for path in systems.values():
        if not path.exists():
            missing = unreadable(path, FileNotFoundError())
            raise InterfaceError(f"{missing}: run `flexhex run` first, it fits p and builds")
    machine, path = load_machine(machine_file), truth_file(machine_file)
    truth = load_truth(path) if path.exists() else None
    hashes = {case: _hash(path) for case, path in systems.items()}
    for path in systems.values():
        _check_machine(path, machine, truth)
    listed = []
    for number in range(1, plan.runs + 1):
        parameters, drawn = draw(plan, number, machine, truth)
        for case, path in systems.items():
            key = _key(hashes[case], parameters, plan.duration)
            listed.append(Task(case, number, path, plan.duration, parameters, drawn, key))
    return tuple(listed)


def carry_out(
    plan: StudyPlan,
    listed: Sequence[Task],
    store: Store,
    pool: Pool,
    advance: Callable[[float, float], None] = lambda done, total: None,
) -> StudyResult:
    """Do what is not in the store yet, keep each run as it ends; advance(done, total) tasks."""
    scored = {t.key: store.done[t.key] for t in listed if t.key in store.done}
    waiting = [t for t in listed if t.key not in scored]
    kept, failed = len(scored), {}
    advance(kept, len(listed))
    for task, outcome in pool(waiting) if waiting else ():
        if isinstance(outcome, str):
            failed[task.key] = f"{task.case}, run {task.number}: {outcome}"
        else:
            store.add(outcome)
            scored[task.key] = outcome
        advance(len(scored) + len(failed), len(listed))
    return StudyResult(plan, tuple(listed), scored, failed, kept)


def score(task: Task, content: bytes | None = None, cache: Path | None = None) -> Scored:
    """Run a task and reduce it to its figures; content is the .ssp where its path is not."""
    if content is not None:
        with tempfile.TemporaryDirectory(prefix="flexhex-") as folder:
            path = Path(folder) / task.ssp.name
            path.write_bytes(content)
            return _score(task, path, cache)
    return _score(task, task.ssp, cache)


def _score(task: Task, path: Path, cache: Path | None) -> Scored:
    result = run(
        path,
        SETTLE + task.duration,
        signals=SIGNALS,
        parameters=task.parameters,
        timing=False,
        cache=cache,
    )
    judged = result.time("feedback.e") > SETTLE
    faults = [np.count_nonzero(result[name]) for name in ("feedback.fault", "plant.fault")]
    return Scored(
        task.key,
        task.case,
        task.number,
        rms(result["feedback.e"][judged]),
        rms(result["feedback.tau_fb"][judged]),
        int(sum(faults)),
        dict(task.drawn),
    )


def _check_machine(path: Path, machine: Machine, truth: Truth | None) -> None:
    """UsageError when a system holds another machine than the file and its truth say."""
    variables = read_ssp(path).instance("plant").fmu.variables
    if truth is None:
        starts = {v.name: tuple(map(float, v.starts)) for v in plant_parameters(machine)}
        names: tuple[str, ...] = ("mechanism", "actuator")
    else:
        starts, names = start_values(machine, truth), (*BUILT, "drift_torque")
    for name in names:
        built = [v.start for v in variables.values() if v.array == name]
        if built != list(starts[name]):
            raise UsageError(
                f"{path}: holds another machine than {machine.name} ({name} differs):"
                " run `flexhex run` with this machine first"
            )


def _hash(path: Path) -> str:
    return hashlib.sha256(read_bytes(path)).hexdigest()


def _key(system: str, parameters: Values, duration: float) -> str:
    text = json.dumps([system, sorted(parameters.items()), duration, SETTLE])
    return hashlib.sha256(text.encode()).hexdigest()[:24]
