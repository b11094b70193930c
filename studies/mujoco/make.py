"""`make`: a case's logs, machine file and sealed truth."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

from studies.mujoco import hexapod
from studies.mujoco.draw import FIRST_TEST
from studies.mujoco.logger import logged, write
from studies.mujoco.machine import toml
from studies.mujoco.runs import runs_of, simulate
from studies.mujoco.truth import FAMILY, truth_of


@dataclass(frozen=True)
class Written:
    """Files of a case: logs to fit, logs of a trajectory for tests, machine file, sealed truth."""

    paths: tuple[Path, ...]
    test_paths: tuple[Path, ...]
    machine_file: Path
    sealed: Path


def make(
    seed: int,
    logs: Path,
    sealed: Path,
    *,
    category: str | None = None,
    kind: str | None = None,
    effect: str | None = None,
    test: bool = False,
    bare: bool = False,
) -> Written:
    """Write a case: logs and machine file into `logs`, the truth into `sealed`.

    category, kind (of machine), effect (id): instead of those that the seed draws. bare: the same
    machine, motions and noise with nothing hidden. ValueError for a test seed without `test`, and
    when one folder lies in the other.
    """
    refuse(seed, test)
    one, two = logs.resolve(), sealed.resolve()
    if one == two or one in two.parents or two in one.parents:
        raise ValueError(f"{sealed}: the truth must lie apart from the logs in {logs}")
    simulated = simulate(seed, category, kind, effect)
    if bare:
        simulated = runs_of(simulated.case, ())
        simulated = replace(simulated, case=replace(simulated.case, hidden=(), category="nothing"))
    case = simulated.case
    logs.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    fit, kept = list[Path](), list[Path]()
    for log in logged(case, simulated.effects, simulated.records, simulated.scale):
        path = logs / f"{log.name}.{case.ending}"
        write(log, path, case.machine.units)
        (kept if log.test else fit).append(path)
    machine_file = logs / "machine.toml"
    chain, reach = case.written.chain, max(case.machine.reach)
    known = case.mass_error, case.geometry_error
    text = toml(case.written, *known) if chain is None else hexapod.toml(chain, reach, *known)
    machine_file.write_text(text)
    truth = sealed / f"{FAMILY}-{seed}.json"
    truth.write_text(json.dumps(truth_of(simulated), indent=1) + "\n", encoding="utf-8")
    return Written(tuple(fit), tuple(kept), machine_file, truth)


def refuse(seed: int, test: bool) -> None:
    """ValueError for a seed below 0, and for a test seed that is not meant."""
    if seed < 0:
        raise ValueError(f"seed {seed}: 0 or more is wanted")
    if seed >= FIRST_TEST and not test:
        raise ValueError(f"seed {seed}: from {FIRST_TEST} on for tests only, say --test")
