"""`python -m studies.hidden_effects [--generator A:B] [--closed A:B] [--mujoco A:B] [--axes A:B]
[--store FILE] [--jobs N] [--test] [--json]`: runs that hide something, diagnosed, judged.

The families of truth are those of `studies/families.py`. Each case is diagnosed from its logs
in a process of its own and scored against the truth, which lies in another folder and is opened by
the scorer alone. The store has one JSON line a case: truth, answer, outcome, processor
seconds, peak memory; twin: where names are right the residual of the same machine with nothing
hidden. A study goes on where it stopped, on the commit that it began with.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import tempfile
import traceback
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from results.record import provenance
from studies import honest_tables
from studies.asked import SECONDS, answered
from studies.families import BARE, FAMILIES, refuse
from studies.honest import Outcome, score
from studies.mujoco.simulate import UnstableLoopError
from studies.store import append_line, read_lines

OUT = Path("out") / "hidden"
TODAY = "studies.mujoco.engines:today"
KEPT = ("verdict", "effects", "changed", "residual", "confidence", "notes", "findings")
"""Of an answer: the rest only pictures need."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """A case: family, seed, category instead of the one that the seed draws; and who answers."""

    family: str
    seed: int
    category: str | None = None
    engine: str = TODAY
    seconds: float = SECONDS

    @property
    def key(self) -> tuple[str, int, str | None, str]:
        """What a line of the store is known by."""
        return self.family, self.seed, self.category, self.engine


def case(task: Task) -> Row:
    """Generate, diagnose, judge: the line of a case."""
    folder = tempfile.TemporaryDirectory
    # two folders that do not know each other: nothing near the logs leads to the truth
    with folder(prefix="logs-") as first, folder(prefix="truth-") as second:
        files = FAMILIES[task.family](task.seed, Path(first), Path(second), task.category)
        truth = json.loads(files.sealed.read_text(encoding="utf-8"))
        response = answered(task.engine, files, task.seconds)
    answer = response["answer"]
    outcome = score(answer, truth, response["error"])
    judged = outcome.closed is not None and outcome.outcome in honest_tables.RIGHT
    twin = bare_residual(task) if judged and task.family in BARE else None
    line = {
        "family": task.family,
        "seed": task.seed,
        "category": task.category,
        "engine": task.engine,
        "outcome": {},
        "processor_seconds": response["processor_seconds"],
        "peak_bytes": response["peak_bytes"],
        "error": response["text"],
        "truth": truth,
        "answer": answer and {key: answer[key] for key in KEPT if key in answer},
        "twin": twin,
    }
    return {**line, "outcome": asdict(judge(line, response["error"]))}


def bare_residual(task: Task) -> Row | None:
    """The residual of the same machine with nothing hidden, from its own runs; None where it has no
    answer: then nothing is said of the gap."""
    folder = tempfile.TemporaryDirectory
    with folder(prefix="logs-") as first, folder(prefix="truth-") as second:
        try:
            files = BARE[task.family](task.seed, Path(first), Path(second), task.category)
        except UnstableLoopError as error:
            response: Row = {"answer": None, "text": str(error)}
        else:
            response = answered(task.engine, files, task.seconds)
    if response["answer"] is None:
        _say(f"{task.family} {task.seed}: no residual without what is hidden: {response['text']}")
        return None
    residual: Row = response["answer"]["residual"]
    return residual


def attempt(task: Task) -> Row | str:
    """`case` for a pool: what fails comes back in words, and the study goes on."""
    try:
        return case(task)
    except Exception:
        return traceback.format_exc(limit=6)


def pool(tasks: Sequence[Task], jobs: int) -> Iterator[tuple[Task, Row | str]]:
    """Cases as they end, `jobs` of them side by side."""
    if jobs == 1:
        yield from ((task, attempt(task)) for task in tasks)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as executor:
        futures = {executor.submit(attempt, task): task for task in tasks}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            executor.shutdown(wait=False, cancel_futures=True)


def read(store: Path) -> list[Row]:
    """Lines of a store. ValueError, with the line, for anything else."""

    def checked(row: Row) -> Row:
        outcome_of(row)
        return row

    return read_lines(store, checked)


def outcome_of(row: Mapping[str, Any]) -> Outcome:
    """The outcome of a line, judged by the scorer as it is now."""
    return judge(row, "" if row["answer"] else row["outcome"]["outcome"])


def judge(row: Mapping[str, Any], error: str) -> Outcome:
    """The outcome of a line; without a twin where its family has one nothing of the gap."""
    twin = row.get("twin")
    outcome = score(row["answer"], row["truth"], error, twin)
    return replace(outcome, closed=None) if twin is None and row["family"] in BARE else outcome


def main(arguments: list[str] | None = None) -> int:
    """0; 1 when a case failed."""
    parser = argparse.ArgumentParser(prog="studies.hidden_effects", description=__doc__)
    for name in FAMILIES:
        parser.add_argument(f"--{name}", type=seeds, default=range(0), help="seeds A:B, without B")
    parser.add_argument("--category", help="instead of the one drawn (mujoco)")
    parser.add_argument("--engine", default=TODAY, help="MODULE:FUNCTION")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="an engine has for a case")
    parser.add_argument("--store", type=Path, help=f"default: a file of this commit in {OUT}")
    parser.add_argument("--jobs", type=int, default=1, help="cases side by side")
    parser.add_argument("--test", action="store_true", help="allow seeds of the tests")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    given = parser.parse_args(arguments)
    tasks = [
        Task(name, seed, given.category, given.engine, given.seconds)
        for name in FAMILIES
        for seed in getattr(given, name)
    ]
    store = given.store or OUT / f"study-{provenance()['commit'][:9]}.jsonl"
    try:
        for task in tasks:
            refuse(task.seed, given.test)
        done = {_key(row): row for row in read(store)}
    except ValueError as error:
        parser.error(str(error))
    failed = list[Task]()
    for task, row in pool([t for t in tasks if t.key not in done], given.jobs):
        if isinstance(row, str):
            failed.append(task)
            _say(f"{task.family} {task.seed}: FAILED\n{row}")
            continue
        append_line(store, row)
        done[task.key] = row
        _say(_line(row))
    rows = [done[task.key] for task in tasks if task.key in done]
    outcomes = [outcome_of(row) for row in rows]
    if given.json:
        print(
            json.dumps(
                {"families": honest_tables.families_of(outcomes), "cases": [*map(_short, rows)]}
            )
        )
    else:
        print(honest_tables.text(outcomes))
    if failed:
        _say(f"{len(failed)} cases could not be made and count nowhere")
    return 1 if failed or any(o.outcome == "failed" for o in outcomes) else 0


def _key(row: Mapping[str, Any]) -> tuple[str, int, str | None, str]:
    return row["family"], row["seed"], row["category"], row["engine"]


def _short(row: Mapping[str, Any]) -> Row:
    """A case as the results keep it."""
    effects = (row["answer"] or {}).get("effects", [])
    axes = [e.get("axes") or [] for e in effects]
    changed = [c["parameter"] for c in (row["answer"] or {}).get("changed", [])]
    seconds = row["processor_seconds"]
    outcome = asdict(outcome_of(row))
    return {**outcome, "named_axes": axes, "changed": changed, "processor_seconds": seconds}


def _line(row: Mapping[str, Any]) -> str:
    o = row["outcome"]
    sizes = " ".join(f"{100 * size:.2f}%" for size in o["observable"])
    named = "; ".join("|".join(names) for names in o["named"]) or o["verdict"]
    cost = f"{row['processor_seconds'] or 0:.0f} s {(row['peak_bytes'] or 0) / 1e9:.1f} GB"
    return (
        f"{row['family']} {row['seed']} {o['machine']} {o['category']}:"
        f" {' + '.join(o['hidden']) or '-'} {sizes} -> {named}: {o['outcome']} ({cost})"
    )


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def seeds(text: str) -> range:
    """A:B, or A alone."""
    first, _, end = text.partition(":")
    chosen = range(int(first), int(end) if end else int(first) + 1)
    if not chosen or chosen[0] < 0:
        raise argparse.ArgumentTypeError(f"{text}: A:B with 0 <= A < B, B not included")
    return chosen


if __name__ == "__main__":
    raise SystemExit(main())
