"""`python -m studies.sensitivity [--generator A:B] [--mujoco A:B] [--axes A:B] [--store FILE]
[--elsewhere] [--test] [--json]`: each criterion of the diagnosis halved and doubled, and what
becomes of the cases.

The criteria are those of `diagnosis/selection/criteria.py`; with `--elsewhere` also the numbers of
other modules that decide something, which take far longer. The store has one JSON line a case: its
outcome and names with every variation. A study goes on where it stopped.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from results.record import provenance
from results.tables import sensitivity
from studies.asked import answered
from studies.families import FAMILIES, refuse
from studies.hidden_effects import OUT, seeds
from studies.honest import score
from studies.mujoco import engines
from studies.remembered import remembered
from studies.store import append_line, read_lines
from studies.takers import takers

ENGINE, FURTHER = "studies.sensitivity:varied", "studies.sensitivity:varied_elsewhere"
SECONDS = 7200.0
"""Longest time for all variations of a case."""
USUAL = "as it is"
FACTORS = (0.5, 2.0)
ELSEWHERE = (
    ("regression.linearize", "HISTORY"),
    ("jointfit.answer", "CORRELATED"),
    ("jointfit.fit", "MISLED"),
    ("jointfit.fit", "EXPLAINED"),
    ("jointfit.calmest", "QUIET"),
    ("jointfit.calmest", "KEPT"),
    ("jointfit.guard", "POOR"),
    ("jointfit.guard", "TOGETHER"),
    ("runs.pairing", "BADLY"),
    ("runs.pairing", "EVIDENCE"),
    ("runs.nominal", "NEARLY"),
    ("drives.late", "INEXACT"),
    ("drives.late", "FITS"),
    ("drives.late", "APART"),
    ("drives.drives", "APART"),
    ("drives.drives", "NOTICED"),
    ("runs.noise", "ALIKE"),
    ("runs.noise", "INEXACT"),
    ("runs.rests", "SLOW"),
    ("runs.rests", "TURN"),
    ("reversals", "REACH"),
    ("reversals", "NEAR"),
    ("reversals", "FEW"),
    ("prepare", "MOVES"),
    ("regression.window", "NOISE"),
    ("regression.window", "SMALLEST_REPEATABLE"),
    ("jointfit.guard", "BENT"),
    ("hypotheses.scales", "PERIODS"),
    ("selection.orders", "SHOWN"),
    ("selection.orders", "OVERTONES"),
    ("selection.evidence", "INEXACT"),
    ("selection.feedback", "BANDS"),
    ("selection.form", "PLACES"),
    ("selection.form", "MANY"),
    ("selection.refine", "GOOD"),
)
"""Numbers of modules of `flexhex.diagnosis` that decide what is asked or what is said."""
Answer = dict[str, Any]


@dataclass(frozen=True)
class Variation:
    """A number with another value: module of `flexhex.diagnosis`, "" for a criterion, and name."""

    module: str
    name: str
    factor: float

    @property
    def label(self) -> str:
        """How the store and the table call it."""
        where = f"{self.module}.{self.name}" if self.module else self.name
        return f"{where} x {self.factor:g}"


def criteria() -> Any:
    """The one object that has the criteria."""
    return importlib.import_module("flexhex.diagnosis.selection.criteria").USUAL


def value_of(module: str, name: str) -> float:
    """A number as it is."""
    holder = importlib.import_module(f"flexhex.diagnosis.{module}") if module else criteria()
    value: float = getattr(holder, name)
    return value


def variations(elsewhere: bool = False) -> list[Variation]:
    """All of them: of the criteria, or of the numbers elsewhere."""
    names = ELSEWHERE if elsewhere else [("", field.name) for field in fields(criteria())]
    return [Variation(module, name, factor) for module, name in names for factor in FACTORS]


@contextmanager
def changed(variation: Variation) -> Iterator[None]:
    """The number has its other value, in this process; whole numbers stay whole, at least one."""
    before = value_of(variation.module, variation.name)
    other = before * variation.factor
    if isinstance(before, int):
        other = max(1, round(other))
    put(variation, other)
    try:
        yield
    finally:
        put(variation, before)


def put(variation: Variation, value: float) -> None:
    """Give a number a value, wherever it was imported to. The criteria are frozen for all who
    decide by them, but not here."""
    if not variation.module:
        object.__setattr__(criteria(), variation.name, value)
        return
    for module in takers(f"flexhex.diagnosis.{variation.module}", variation.name):
        setattr(module, variation.name, value)


def varied(paths: Sequence[Path], test_paths: Sequence[Path], machine_file: Path) -> Answer:
    """An engine: its answers by variation of the criteria."""
    with remembered():
        return _varied((paths, test_paths, machine_file), variations())


def varied_elsewhere(
    paths: Sequence[Path], test_paths: Sequence[Path], machine_file: Path
) -> Answer:
    """The same of the numbers elsewhere."""
    return _varied((paths, test_paths, machine_file), variations(True))


def _varied(
    files: tuple[Sequence[Path], Sequence[Path], Path], listed: Sequence[Variation]
) -> Answer:
    answers = {USUAL: engines.today(*files)}
    for variation in listed:
        with changed(variation):
            answers[variation.label] = engines.today(*files)
    keys = ("verdict", "effects", "changed", "findings")
    return {name: {key: answer[key] for key in keys} for name, answer in answers.items()}


def case(family: str, seed: int, engine: str) -> Answer:
    """The line of a case."""
    folder = tempfile.TemporaryDirectory
    with folder(prefix="logs-") as first, folder(prefix="truth-") as second:
        files = FAMILIES[family](seed, Path(first), Path(second), None)
        truth = json.loads(files.sealed.read_text(encoding="utf-8"))
        response = answered(engine, files, SECONDS)
    outcomes = {}
    for name, answer in (response["answer"] or {}).items():
        judged = score(answer, truth)
        effects = [[e["id"], e.get("axes") or []] for e in answer["effects"]]
        outcomes[name] = {"outcome": judged.outcome, "verdict": judged.verdict, "effects": effects}
    return {
        "family": family,
        "seed": seed,
        "engine": engine,
        "category": truth["category"],
        "hidden": [[h["id"], h["axes"], h["observable"]] for h in truth["hidden"]],
        "error": response["text"],
        "processor_seconds": response["processor_seconds"],
        "outcomes": outcomes,
    }


def summary(cases: Sequence[Mapping[str, Any]]) -> Answer:
    """Of every variation how many cases end well, with something named that is not there, and
    otherwise than usual; the cases that do."""
    answered_ = [c for c in cases if c["outcomes"]]
    names = dict.fromkeys(name for c in answered_ for name in c["outcomes"])
    rows = {}
    for name in names:
        own = [c for c in answered_ if name in c["outcomes"]]
        words = [c["outcomes"][name]["outcome"] for c in own]
        moved = [
            f"{c['family']} {c['seed']}: {c['outcomes'][USUAL]['outcome']} -> {word}"
            for c, word in zip(own, words, strict=True)
            if word != c["outcomes"][USUAL]["outcome"]
        ]
        good = sum(w in ("right", "ambiguous", "all", "silent", "detected") for w in words)
        bad = sum(w in ("wrong", "false_alarm") or w.endswith("+wrong") for w in words)
        rows[name] = {"n": len(own), "good": good, "wrong": bad, "moved": moved}
    listed = [
        (v.module, v.name) for v in (*variations(), *variations(True)) if v.factor == FACTORS[0]
    ]
    values = {f"{m}.{n}" if m else n: value_of(m, n) for m, n in listed}
    return {"values": values, "variations": rows, "cases": len(answered_)}


def main(arguments: list[str] | None = None) -> int:
    """0; 1 when a case got no answer."""
    parser = argparse.ArgumentParser(prog="studies.sensitivity", description=__doc__)
    for name in FAMILIES:
        parser.add_argument(f"--{name}", type=seeds, default=range(0), help="seeds A:B, without B")
    parser.add_argument("--elsewhere", action="store_true", help="the numbers of other modules")
    parser.add_argument("--store", type=Path, help=f"default: a file of this commit in {OUT}")
    parser.add_argument("--test", action="store_true", help="allow seeds of the tests")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    given = parser.parse_args(arguments)
    engine = FURTHER if given.elsewhere else ENGINE
    tasks = [(name, seed, engine) for name in FAMILIES for seed in getattr(given, name)]
    store = given.store or OUT / f"sensitivity-{provenance()['commit'][:9]}.jsonl"
    try:
        for _, seed, _ in tasks:
            refuse(seed, given.test)
        done = dict(
            read_lines(store, lambda row: ((row["family"], row["seed"], row["engine"]), row))
        )
    except ValueError as error:
        parser.error(str(error))
    for task in (t for t in tasks if t not in done):
        done[task] = case(*task)
        append_line(store, done[task])
        moved = summary([done[task]])["variations"]
        said = [f"{name} ({row['moved'][0]})" for name, row in moved.items() if row["moved"]]
        print(f"{task[0]} {task[1]}: {'; '.join(said) or 'no change'}", file=sys.stderr, flush=True)
    results = summary([done[task] for task in tasks])
    print(json.dumps(results) if given.json else sensitivity(results))
    return 0 if all(done[task]["outcomes"] for task in tasks) else 1


if __name__ == "__main__":
    raise SystemExit(main())
