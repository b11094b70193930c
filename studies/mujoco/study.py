"""`python -m studies.mujoco.study --seeds A:B --store FILE [--engine MODULE:FUNCTION] [--test]
[--seconds S] [--category C]`: cases generated, diagnosed in a process of their own, judged.

The store has one JSON line a case: truth, answer, outcome, processor seconds, peak memory. A study
goes on where it stopped. Its table is printed at the end.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from studies.honest import Outcome, score
from studies.honest_tables import text
from studies.mujoco.draw import SHARES
from studies.mujoco.make import make, refuse
from studies.store import append_line, read_lines

TODAY = "studies.mujoco.engines:today"
SECONDS = 900.0
"""Longest time that an engine has for a case."""


def case(
    seed: int, engine: str, *, test: bool = False, seconds: float = SECONDS, category: str | None
) -> dict[str, Any]:
    """Generate, diagnose, judge: the line of a case."""
    folder = tempfile.TemporaryDirectory
    # two folders that do not know each other: nothing near the logs leads to the truth
    with folder(prefix="logs-") as first, folder(prefix="truth-") as second:
        made = make(seed, Path(first), Path(second), test=test, category=category)
        truth = json.loads(made.sealed.read_text(encoding="utf-8"))
        wanted = {
            "paths": [str(p) for p in made.paths],
            "test_paths": [str(p) for p in made.test_paths],
            "machine_file": str(made.machine_file),
        }
        found = _apart(engine, wanted, seconds)
    outcome = score(found["answer"], truth, found["error"])
    return {
        "seed": seed,
        "engine": engine,
        "outcome": asdict(outcome),
        "processor_seconds": found["processor_seconds"],
        "peak_bytes": found["peak_bytes"],
        "error": found["text"],
        "truth": truth,
        "answer": _short(found["answer"]),
    }


def _apart(engine: str, wanted: Mapping[str, Any], seconds: float) -> dict[str, Any]:
    """What the engine says in its own process."""
    with tempfile.TemporaryDirectory(prefix="answer-") as name:
        request, target = Path(name) / "request.json", Path(name) / "answer.json"
        request.write_text(json.dumps(wanted), encoding="utf-8")
        command = [sys.executable, "-m", "studies.mujoco.engines", engine]
        command += [str(request), str(target)]
        try:
            done = subprocess.run(command, timeout=seconds, capture_output=True, text=True)
            if target.exists():
                found: dict[str, Any] = json.loads(target.read_text(encoding="utf-8"))
                return found
            said = f"ended with {done.returncode}: {done.stderr[-2000:]}"
        except subprocess.TimeoutExpired:
            said = f"no answer within {seconds:.0f} s"
    empty = {"processor_seconds": None, "peak_bytes": None}
    return {"answer": None, "error": "failed", "text": said, **empty}


def _short(answer: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """An answer without what only pictures need."""
    if answer is None:
        return None
    keys = ("verdict", "effects", "changed", "gap", "confidence", "notes", "findings")
    return {key: answer[key] for key in keys if key in answer}


def read(store: Path) -> list[dict[str, Any]]:
    """Lines of a store. ValueError, with the line, for anything else."""

    def checked(row: dict[str, Any]) -> dict[str, Any]:
        outcome_of(row)
        return row

    return read_lines(store, checked)


def outcome_of(row: Mapping[str, Any]) -> Outcome:
    """The outcome of a line."""
    values: dict[str, Any] = {
        key: tuple(tuple(v) if isinstance(v, list) else v for v in value)
        if isinstance(value, list)
        else value
        for key, value in row["outcome"].items()
    }
    return Outcome(**values)


def main(arguments: list[str] | None = None) -> int:
    """0; 1 where an engine failed on a case."""
    parser = argparse.ArgumentParser(prog="studies.mujoco.study", description=__doc__)
    parser.add_argument("--seeds", type=_range, required=True, help="A:B, B not included")
    parser.add_argument("--engine", default=TODAY)
    parser.add_argument("--store", type=Path, required=True)
    parser.add_argument("--category", choices=list(SHARES), help="instead of the one drawn")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="an engine has for a case")
    parser.add_argument("--test", action="store_true", help="allow seeds of the tests")
    given = parser.parse_args(arguments)
    try:
        refuse(given.seeds[-1], given.test)
        done = read(given.store)
    except ValueError as error:
        parser.error(str(error))
    before = {(row["seed"], row["engine"], row.get("category")) for row in done}
    for seed in given.seeds:
        if (seed, given.engine, given.category) in before:
            continue
        row = case(
            seed, given.engine, test=given.test, seconds=given.seconds, category=given.category
        )
        row["category"] = given.category
        append_line(given.store, row)
        done.append(row)
        _say(row)
    ours = [row for row in done if row["engine"] == given.engine and row["seed"] in given.seeds]
    print(text([outcome_of(row) for row in ours]))
    return 1 if any(row["outcome"]["outcome"] == "failed" for row in ours) else 0


def _say(row: Mapping[str, Any]) -> None:
    o = row["outcome"]
    sizes = " ".join(f"{100 * size:.2f}%" for size in o["observable"])
    named = "; ".join("|".join(names) for names in o["named"]) or o["verdict"]
    cost = f"{row['processor_seconds'] or 0:.0f} s {(row['peak_bytes'] or 0) / 1e9:.1f} GB"
    print(
        f"{row['seed']} {o['machine']} {o['category']}: {' + '.join(o['hidden']) or '-'} {sizes}"
        f" -> {named}: {o['outcome']} ({cost})",
        file=sys.stderr,
        flush=True,
    )


def _range(text: str) -> range:
    first, _, end = text.partition(":")
    found = range(int(first), int(end) if end else int(first) + 1)
    if not found or found[0] < 0:
        raise argparse.ArgumentTypeError(f"{text}: A:B with 0 <= A < B, B not included")
    return found


if __name__ == "__main__":
    raise SystemExit(main())
