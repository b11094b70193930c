"""Speed: medians and ratios side by side, beside rivals, and beside another revision of this."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks import (
    adapter,
    against,
    diagnosis,
    growth,
    kalman,
    loop,
    mechanism,
    parallel,
    plant,
    tables,
    view,
    waits,
)
from benchmarks.blocks import operations
from benchmarks.clock import Row, pin
from flexhex.fmus.common.errors import FlexhexError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from results.record import computer

MACHINE_FILE = Path("machines") / "tflex.toml"
BLOCKS = ("kinematics", "feedforward", "estimator", "plant", "filter", "reference", "feedback")
ROWS: dict[str, Callable[[Machine, int], Row]] = {
    "N": mechanism.step_N,
    "chain": mechanism.chain_row,
    "kalman": kalman.kalman_row,
    "plant": plant.plant_row,
    "adapter": adapter.adapter_row,
    "loop": lambda machine, rounds: loop.loop_row(MACHINE_FILE, rounds),
    **{key: waits.row_of(key) for key in waits.COMMANDS},
    **{key: diagnosis.row_of(key) for key in diagnosis.CASES},
    **view.ROWS,
}
LONG = ("run", "test", *diagnosis.CASES, *view.ROWS)
"""Benchmarks that take minutes: measured when they are named, or with `--long`."""
MORE = ("growth", "profile")


def main(arguments: list[str] | None = None) -> int:
    """Run what was asked for; 0, 1 when a required limit is missed or something has become
    slower, 2 and 3 for mistakes."""
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--only", choices=(*ROWS, *MORE), help="one benchmark alone")
    parser.add_argument("--long", action="store_true", help="also what takes minutes")
    parser.add_argument("--rounds", type=int, default=25, help="bursts of each rival")
    parser.add_argument(
        "--against",
        metavar="REVISION",
        help="only compare with a revision of git, or with the recorded one; fails on what has"
        f" become slower by more than {against.WORSE - 1:.0%}".replace("%", " %%"),
    )
    options = parser.parse_args(arguments)
    if options.rounds < 3:
        parser.error(f"--rounds {options.rounds}: at least 3, a median of fewer says nothing")
    try:
        if options.against:
            measured = versus(options.against, options.only)
        else:
            measured = collect(options.only, options.rounds, options.long)
    except FlexhexError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return 3
    if options.json:
        print(json.dumps(measured, default=_plain, indent=1))
    else:
        tables.show(measured, Console(width=None if sys.stdout.isatty() else 130))
    missed = any(row.met(row.required) is False for row in measured["rows"])
    return int(missed or any(one.worse for one in measured.get("changes", ())))


def versus(revision: str, only: str | None) -> dict[str, Any]:
    """What has become of the speed since a revision."""
    keys = [only] if only else [*against.BLOCKS, *against.WAITS]
    before = pin()
    try:
        return {"where": computer(), "rows": [], "changes": against.compare(revision, keys)}
    finally:
        if before:
            os.sched_setaffinity(0, before)


def collect(only: str | None, rounds: int, long: bool = False) -> dict[str, Any]:
    """Everything measured: where, rows, growth, profile. long: what takes minutes, too."""
    machine, before = load_machine(MACHINE_FILE), pin()
    try:
        short = [key for key in ROWS if long or key not in LONG]
        wanted = [only] if only else [*short, *MORE]
        measured: dict[str, Any] = {"where": computer(), "rows": []}
        for name in wanted:
            if name in ROWS:
                measured["rows"].append(ROWS[name](machine, rounds))
        if "growth" in wanted:
            measured["growth"] = grown(machine, rounds, before)
        if "profile" in wanted:
            ssp = loop.system(MACHINE_FILE)
            measured["profile"] = loop.where(ssp)
            measured["operations"] = {block: operations(block, machine) for block in BLOCKS}
        return measured
    finally:
        if before:
            os.sched_setaffinity(0, before)


def grown(machine: Machine, rounds: int, cores: list[int]) -> dict[str, Any]:
    """Parameters -> ns of K; (loops, cores) -> simulated seconds in a second of the clock and of
    processor time; kind of C -> what two cores do for one."""
    ssp, pairs = loop.system(MACHINE_FILE), [(1, 1), (4, 1), (2, 2), (4, 2), (8, 2)]
    known = [pair for pair in pairs if pair[1] <= max(len(cores), 1)]
    return {
        "parameters": growth.by_parameters(machine, max(3, rounds // 3)),
        "loops": {
            f"{loops} loops, {count} cores": parallel.loops_side_by_side(ssp, loops, cores[:count])
            for loops, count in known
        },
        "cores": parallel.own(cores) if len(cores) > 1 else {},
    }


def _plain(value: Any) -> Any:
    if isinstance(value, Row):
        return dataclasses.asdict(value) | {
            "met_required": value.met(value.required),
            "met_stretch": value.met(value.stretch),
            "ratios": {timing.name: value.ratio(timing) for timing in value.timings[1:]},
        }
    return dataclasses.asdict(value)


if __name__ == "__main__":
    sys.exit(main())
