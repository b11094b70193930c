"""`flexhex study`: the same loop on many machines, drawn at random; only figures are kept.

Run number k of a seed is the same draw whatever the number of runs and whatever else varies,
so a study can grow. Both cases of a run get the same draw. Every finished run is one JSON
line; its key is a hash of the .ssp, all parameters and the duration, so nothing runs twice.
"""

from __future__ import annotations

import hashlib
import json
import math
import random
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, truth_file
from flexhex.fmus.machine.truth import Truth, interface, load_truth
from flexhex.simulation.cases import SETTLE, WARM
from flexhex.simulation.metrics import rms
from flexhex.ssp.executor import run
from flexhex.ssp.fmu import read_bytes
from flexhex.ssp.library import DEFAULT_CACHE
from flexhex.ssp.read import read_ssp
from flexhex.study.store import Scored, Store

CASES = ("fixed", "adaptive")
VARIED = {
    "noise": "seed of the noise",
    "payload": "mass at the end-effector from the start on",
    "age": "time since the machine was switched on",
    "drift": "offset torques that creep in",
    "truth": "the machine itself: inertias, stiffness, actuators, cogging; p stays as fitted",
    "trajectory": "seed of the setpoints",
}
"""What a study can draw anew for every run."""
DEFAULT_VARIED = ("noise", "payload", "age", "drift")
BUILT = ("mechanism", "actuator", "hidden_cogging")
"""Parameters of machine.fmu that `truth` draws."""
SIGNALS = ("feedback.e", "feedback.tau_fb", "feedback.fault", "plant.fault")
Values = Mapping[str, float | tuple[float, ...]]


@dataclass(frozen=True)
class Plan:
    """What a study does: runs, judged time [s], seed, what varies, largest payload [kg] and
    age [s]."""

    runs: int = 20
    duration: float = 10.0
    seed: int = 1
    varied: tuple[str, ...] = DEFAULT_VARIED
    payload: float = 1.0
    age: float = 2 * WARM

    def check(self) -> None:
        """UsageError for a plan that cannot be."""
        if self.runs < 1 or self.seed < 0:
            raise UsageError(f"--runs {self.runs}, --seed {self.seed}: at least 1 and 0")
        sizes = {"duration": self.duration, "payload": self.payload, "age": self.age}
        for name, value in sizes.items():
            if not (math.isfinite(value) and value > 0):
                raise UsageError(f"--{name} {value:g}: must be above 0")
        if not self.varied:
            raise UsageError(f"--vary: all runs would be the same, choose of {', '.join(VARIED)}")
        for name in self.varied:
            if name not in VARIED:
                raise UsageError(f"--vary {name!r}: there are {', '.join(VARIED)}")


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
class Found:
    """What a study gave: figures by key in the order of the tasks, failed runs in words."""

    plan: Plan
    tasks: tuple[Task, ...]
    scored: Mapping[str, Scored]
    failed: Mapping[str, str] = field(default_factory=dict)
    kept: int = 0
    wall: float = 0.0

    def of(self, case: str) -> list[Scored]:
        """Finished runs of a case, by number."""
        return [self.scored[t.key] for t in self.tasks if t.case == case and t.key in self.scored]

    def pairs(self) -> list[tuple[Scored, Scored]]:
        """Fixed and adaptive figures of the same draw, where both are there."""
        adaptive = {s.number: s for s in self.of("adaptive")}
        return [(s, adaptive[s.number]) for s in self.of("fixed") if s.number in adaptive]


Pool = Callable[[Sequence[Task]], Iterator[tuple[Task, Scored | str]]]


def tasks(plan: Plan, machine_file: Path, out: Path) -> tuple[Task, ...]:
    """All runs of a plan on the systems that `flexhex run` left in `out/cases`, both cases of
    a draw one after the other. UsageError when they are missing or of another machine."""
    plan.check()
    systems = {case: out / "cases" / case / "hexapod.ssp" for case in CASES}
    for path in systems.values():
        if not path.exists():
            raise UsageError(f"{path}: no such file: run `flexhex run` first, it fits p and builds")
    machine, truth = load_machine(machine_file), load_truth(truth_file(machine_file))
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


def draw(
    plan: Plan, number: int, machine: Machine, truth: Truth
) -> tuple[Values, Mapping[str, float]]:
    """Parameters of run `number`, and the few of them that are shown.

    Every kind has random numbers of its own: varying one more leaves the others as they are.
    """

    def dice(what: str) -> random.Random:
        return random.Random(f"{plan.seed}:{number}:{what}")

    found: dict[str, float | tuple[float, ...]] = {}
    shown: dict[str, float] = {}
    if "noise" in plan.varied:
        found["plant.seed"] = shown["noise"] = float(dice("noise").randrange(2**53))
    if "payload" in plan.varied:
        mass = shown["payload"] = dice("payload").uniform(0, plan.payload)
        found["reference.payload_count"] = 1.0
        found |= {"reference.payload_time[1]": 0.0, "reference.payload_mass[1]": mass}
    if "age" in plan.varied:
        found["plant.age"] = shown["age"] = dice("age").uniform(0, plan.age)
    if "drift" in plan.varied:
        found |= _machine(machine, truth, dice("drift").randrange(2**53), ("drift_torque",))
    if "truth" in plan.varied:
        found |= _machine(machine, truth, dice("truth").randrange(2**53), BUILT)
    if "trajectory" in plan.varied:
        found["reference.seed"] = shown["trajectory"] = float(dice("trajectory").randrange(2**53))
    return found, shown


def study(
    plan: Plan,
    listed: Sequence[Task],
    store: Store,
    pool: Pool,
    advance: Callable[[int, int], None] = lambda done, total: None,
) -> Found:
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
    return Found(plan, tuple(listed), scored, failed, kept)


def score(task: Task, content: bytes | None = None, cache: Path = DEFAULT_CACHE) -> Scored:
    """Run a task and reduce it to its figures; content is the .ssp where its path is not."""
    if content is not None:
        with tempfile.TemporaryDirectory(prefix="flexhex-") as folder:
            path = Path(folder) / task.ssp.name
            path.write_bytes(content)
            return _score(task, path, cache)
    return _score(task, task.ssp, cache)


def _score(task: Task, path: Path, cache: Path) -> Scored:
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


@lru_cache(maxsize=8)
def _machine_of(machine: Machine, truth: Truth) -> dict[str, tuple[float, ...]]:
    """Start values of machine.fmu by name, as its build draws them from a truth."""
    variables = interface(machine, truth).variables
    return {v.name: tuple(float(x) for x in v.starts) for v in variables}


def _machine(
    machine: Machine, truth: Truth, seed: int, names: Sequence[str]
) -> dict[str, tuple[float, ...]]:
    """Parameters of another machine of the same make."""
    drawn = _machine_of(machine, truth.model_copy(update={"seed": seed}))
    return {f"plant.{name}": drawn[name] for name in names}


def _check_machine(path: Path, machine: Machine, truth: Truth) -> None:
    """UsageError when a system holds another machine than the file and its truth say."""
    variables = read_ssp(path).instance("plant").fmu.variables
    for name, values in _machine_of(machine, truth).items():
        if name not in (*BUILT, "drift_torque"):
            continue
        names = [f"{name}[{k}]" for k in range(1, len(values) + 1)]
        starts = [variables[n].start for n in names if n in variables]
        if starts != list(values):
            raise UsageError(
                f"{path}: holds another machine than {machine.name} ({name} differs):"
                " run `flexhex run` with this machine first"
            )


def _hash(path: Path) -> str:
    return hashlib.sha256(read_bytes(path)).hexdigest()


def _key(system: str, parameters: Values, duration: float) -> str:
    text = json.dumps([system, sorted(parameters.items()), duration, SETTLE])
    return hashlib.sha256(text.encode()).hexdigest()[:24]
