"""`python -m studies.hidden_effects --seeds A:B [--closed A:B] [--machines] [--jobs N]
[--dask ADDRESS] [--store FILE] [--json]`: runs in which an effect is hidden, diagnosed, judged.

Each case comes from `studies/generator`, which shares no code with the library of effects. It is
diagnosed from its logs and scored against the truth, which lies in another folder and is
opened by the scorer alone. The store has one JSON line per case: a study goes on where it stopped,
on the commit that it began with.
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from results.record import provenance
from studies import tables
from studies.generator.closed import closed_case, simulate_closed
from studies.generator.draw import Case, draw
from studies.generator.inverse import simulate
from studies.generator.machines import COUNT, machine
from studies.generator.write import Written, write
from studies.score import Score, beside, score
from studies.store import Store, Task

OUT = Path("out") / "hidden"
MACHINE_FILE = Path("machines") / "tflex.toml"
SIDE_BY_SIDE = 8
"""Closed-loop cases integrated at one step."""
Diagnose = Callable[[Sequence[Path], Sequence[Path], Path], dict[str, Any]]


def diagnose(paths: Sequence[Path], locked: Sequence[Path], machine_file: Path) -> dict[str, Any]:
    """What `flexhex diagnose --json` prints, in this process, with the default options."""
    workflow: Any = importlib.import_module("flexhex.diagnosis.workflow")
    found: dict[str, Any] = workflow.diagnose_files(paths, locked, machine_file)
    return found


def case_of(task: Task) -> Case:
    """The case that a task stands for."""
    kinds: dict[str, Callable[[int], Case]] = {
        "seed": draw,
        "closed": closed_case,
        "machine": machine,
    }
    return kinds[task[0]](task[1])


def generate(case: Case, logs: Path, sealed: Path, ending: str = "h5") -> Written:
    """Logs and sealed truth of a case."""
    if case.closed:
        return write(case, simulate_closed([case], OUT / "closed")[0], logs, sealed, ending)
    return write(case, simulate(case), logs, sealed, ending)


def judge(task: Task, diagnose: Diagnose = diagnose, keep: Path | None = None) -> Score:
    """Generate, diagnose, score; where an effect that is to be seen was named, the same runs
    without it as well. Logs and truth go to folders apart, removed afterwards unless they are kept
    under `keep`."""
    case = case_of(task)
    found, judged = _judged(case, diagnose, keep)
    if found["effects"] and any(part >= tables.SEEN for part in judged.observable):
        twin, _ = _judged(without(case), diagnose)
        judged = beside(judged, twin)
    return judged


def without(case: Case) -> Case:
    """The same motion and noise with nothing hidden."""
    return replace(case, hidden=())


def _judged(
    case: Case, diagnose: Diagnose, keep: Path | None = None
) -> tuple[dict[str, Any], Score]:
    # two folders that do not know each other: nothing near the logs leads to the truth
    folder = tempfile.TemporaryDirectory
    with folder(prefix="hidden-") as first, folder(prefix="sealed-") as second:
        # every ninth case as CSV: slower to read, the same numbers
        ending = "csv" if case.seed % 9 == 4 else "h5"
        written = generate(case, Path(first), Path(second), ending)
        found = diagnose(written.paths, written.locked, MACHINE_FILE)
        judged = score(found, written.sealed)
        if keep is not None:
            shutil.copytree(first, keep / "logs" / str(case.seed), dirs_exist_ok=True)
            shutil.copytree(second, keep / "sealed", dirs_exist_ok=True)
    return found, judged


def close_loops(numbers: Sequence[int]) -> int:
    """Integrate closed-loop cases side by side, which is far quicker than one by one; also the same
    without what they hide, where `judge` may ask for it."""
    cases = [closed_case(k) for k in numbers]
    twins = [without(case) for case in cases if case.category == "single"]
    return len(simulate_closed([*cases, *twins], OUT / "closed"))


def attempt(task: Task) -> Score | str:
    """`judge` for a pool: what fails comes back in words, and the study goes on."""
    try:
        return judge(task)
    except Exception:
        return traceback.format_exc(limit=6)


def local(jobs: int) -> Callable[[Sequence[Task]], Iterator[tuple[Task, Score | str]]]:
    """Processes of this computer."""

    def pool(tasks: Sequence[Task]) -> Iterator[tuple[Task, Score | str]]:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, mp_context=context, initializer=_deaf) as executor:
            futures = {executor.submit(attempt, task): task for task in tasks}
            try:
                for future in as_completed(futures):
                    yield futures[future], future.result()
            finally:
                executor.shutdown(wait=False, cancel_futures=True)

    return pool


def _deaf() -> None:
    """Ctrl-C is for the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def over_dask(address: str) -> Callable[[Sequence[Task]], Iterator[tuple[Task, Score | str]]]:
    """Workers of a dask scheduler; each runs in a checkout of this project."""
    distributed: Any = importlib.import_module("distributed")

    def pool(tasks: Sequence[Task]) -> Iterator[tuple[Task, Score | str]]:
        with distributed.Client(address, timeout=10) as client:
            futures = {client.submit(attempt, task, pure=False): task for task in tasks}
            for future in distributed.as_completed(list(futures)):
                yield futures[future], future.result()

    return pool


def _range(text: str) -> range:
    first, _, end = text.partition(":")
    found = range(int(first), int(end) if end else int(first) + 1)
    if not found or found[0] < 0:
        raise argparse.ArgumentTypeError(f"{text}: A:B with 0 <= A < B, B not included")
    return found


def main(arguments: list[str] | None = None) -> int:
    """0; 1 when a case failed."""
    parser = argparse.ArgumentParser(prog="hidden_effects", description=__doc__)
    parser.add_argument("--seeds", type=_range, default=range(0), help="A:B, B not included")
    parser.add_argument("--closed", type=_range, default=range(0), help="of the closed loop")
    parser.add_argument("--machines", action="store_true", help=f"the {COUNT} of the showcase")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--dask", metavar="ADDRESS", help="tcp://host:port of a scheduler")
    parser.add_argument("--store", type=Path, help="default: a file of this commit in out/hidden")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    given = parser.parse_args(arguments)
    tasks: list[Task] = [("seed", k) for k in given.seeds]
    tasks += [("closed", k) for k in given.closed]
    tasks += [("machine", k) for k in range(1, COUNT + 1) if given.machines]
    store = Store(given.store or OUT / f"study-{provenance()['commit'][:9]}.jsonl")
    failed = _study(tasks, store, given.jobs, given.dask)
    scores = {t: store.done[t] for t in tasks if t in store.done}
    if given.json:
        found = [asdict(claim) for claim in tables.claims(list(scores.values()))]
        cases = [{"task": task, **asdict(found)} for task, found in scores.items()]
        print(json.dumps({"claims": found, "failed": failed, "cases": cases}))
    else:
        print(tables.text(list(scores.values())))
    if failed:
        _say(f"{len(failed)} cases failed and count nowhere: {failed}")
    return 1 if failed else 0


def _study(tasks: Sequence[Task], store: Store, jobs: int, dask: str | None) -> list[Task]:
    """Run what the store does not have; the cases that failed."""
    waiting, failed = [t for t in tasks if t not in store.done], []
    _say(f"{len(tasks)} cases, {len(tasks) - len(waiting)} done before")
    loops = [number for kind, number in waiting if kind == "closed"]
    groups = [loops[k : k + SIDE_BY_SIDE] for k in range(0, len(loops), SIDE_BY_SIDE)]
    if groups and not dask:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(jobs, len(groups)), mp_context=context) as executor:
            _say(f"{sum(executor.map(close_loops, groups))} closed loops integrated")
    pool = over_dask(dask) if dask else local(jobs)
    for task, found in pool(waiting) if waiting else ():
        if isinstance(found, str):
            failed.append(task)
            _say(f"{task[0]} {task[1]}: FAILED\n{found}")
            continue
        store.add(task, found)
        truth = " + ".join(found.truth) or "nothing"
        said = " + ".join(found.named) or found.verdict
        _say(f"{task[0]} {task[1]}: {truth} -> {said}: {found.outcome}")
    return failed


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
