"""`python -m studies.showcase [--json]`: what machines hide, found from their logs and added.

Machine 0 is the default one; the others are drawn from seeds (`showcase_machines.py`). For each:
logs of machine.fmu under the fixed feedforward, `diagnose`, the extended model built, the adaptive
loop on machine.fmu before and after. Finished machines are lines of OUT/results.jsonl and are not
run again on the same commit.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
import traceback
from pathlib import Path
from typing import Any

from flexhex.diagnose.rebuild import rebuild
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.experiments.missing import CHANNELS, FITTED, HELD_OUT, PASSES, SECONDS, write_log
from flexhex.fmus.common.machine_file import read_toml, truth_file
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import table_cases
from flexhex.ssp.executor import run
from results.record import provenance
from results.tables import machines as table
from studies.honest import score
from studies.showcase_machines import NEAR, SEEN_AS, drawn, write_machine

DEFAULT = Path("machines/tflex.toml")
Line = dict[str, Any]


def record(machine_file: Path, out: Path, seed: int) -> tuple[list[Path], list[Path]]:
    """Logs of the warm machine for the diagnosis, and held-out ones, as HDF5 files in `out`.

    Logs of a run that was broken off are taken as they are.
    """
    names = [[out / f"{t}{k}.h5" for t in kind for k in PASSES] for kind in (FITTED, HELD_OUT)]
    if all(path.exists() for paths in names for path in paths):
        return names[0], names[1]
    builder = Builder(machine_file, out / "recorder")
    _share_cache(builder.out)
    builder.systems()
    fixed = table_cases(builder.machine, base_parameters(builder.machine), SECONDS)[1]
    description = builder.case(fixed)
    for k, trajectory in enumerate((*FITTED, *HELD_OUT)):
        for number in PASSES:
            seeds = {
                "reference.seed": float(7919 * (seed + 1) + k),
                "plant.seed": float(104729 * (seed + 1) + 10 * k + number),
            }
            signals = tuple(signal for signal, _ in CHANNELS.values())
            result = run(description, fixed.duration, signals=signals, parameters=seeds)
            write_log(result, out / f"{trajectory}{number}.h5", trajectory, number)
    return names[0], names[1]


def _share_cache(folder: Path) -> None:
    """One cache of objects for all builders of a showcase: the machines differ in little."""
    shared, link = (Path("out") / "cache").resolve(), folder / "cache"
    shared.mkdir(parents=True, exist_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    if not link.exists():
        link.symlink_to(shared, target_is_directory=True)


def show(number: int, seed: int, machines: int, out: Path) -> Line:
    """One machine from its logs to the closed loop."""
    # of its own draw: logs of another machine of this number are not to be found there
    began, folder = time.monotonic(), out / f"{seed}-{machines}" / f"{number:02d}"
    hidden = drawn(seed, number, machines) if number else ()
    own = 100 * seed + number
    machine_file = write_machine(DEFAULT, folder, hidden, own) if number else DEFAULT
    line: Line = {"number": number, "seed": seed, "machines": machines}
    line["hidden"] = [vars(h) for h in hidden] if number else _default_hidden()
    runs, held_out = record(machine_file, folder, own)
    _say(number, began, "recorded")
    diagnosis = diagnose(runs, held_out, machine_file, Options())
    _say(number, began, f"{diagnosis.verdict}: {', '.join(e.id for e in diagnosis.effects)}")
    line["diagnosis"] = diagnosis.data()
    for sub in ("model", "model/before"):
        _share_cache(folder / sub)
    rebuilt = rebuild(machine_file, diagnosis, folder / "model", runs, held_out)
    line["shown"] = rebuilt.data()
    line["minutes"] = (time.monotonic() - began) / 60
    for path in (*runs, *held_out):
        path.unlink()
    shutil.rmtree(folder / "recorder", ignore_errors=True)
    _say(number, began, str(line["shown"]["closed_loop"]))
    return line


def _default_hidden() -> list[Line]:
    truth = read_toml(truth_file(DEFAULT))
    orders, rms = truth["cogging"]["orders"], truth["cogging"]["rms"]["value"]
    omega = read_toml(DEFAULT)["actuator"]["omega_cog"]["value"]
    entry = {"kind": "harmonic", "axes": [1, 2, 3, 4, 5, 6], "size": rms / 2}
    return [{**entry, "values": {"order": k * omega}} for k in orders]


def _say(number: int, began: float, text: str) -> None:
    took = time.monotonic() - began
    print(f"machine {number}, {took:.0f} s: {text}", file=sys.stderr, flush=True)


def judged(line: Line) -> str:
    """As `studies.honest` says; `, near` where a name is another form of the same thing (`NEAR`);
    `failed`."""
    if "error" in line:
        return "failed"
    strict, wider = (_outcome(line, near) for near in (False, True))
    return strict if strict == wider else f"{wider}, near"


def _outcome(line: Line, near: bool) -> str:
    hidden = [_hidden(h, near) for h in line["hidden"]]
    # beside an effect of the library one outside it has no name that could be right
    inside = [h for h in hidden if h["inside"]] or hidden
    category = ("outside", "single", "pair")[min(sum(h["inside"] for h in hidden), 2)]
    truth = {
        "seed": line["number"],
        "family": "showcase",
        "machine": "hexapod",
        "category": category,
        "hidden": inside,
        "changed": [],
        "passes": len(PASSES),
        "trajectories": [*FITTED, *HELD_OUT],
    }
    return score(line["diagnosis"], truth).outcome


def _hidden(entry: Line, near: bool) -> Line:
    """A hidden effect as the scorer wants it; all of them are large enough to be seen."""
    names = [*SEEN_AS[entry["kind"]], *(NEAR.get(entry["kind"], ()) if near else ())]
    return {
        "id": entry["kind"],
        "accept": names,
        "inside": bool(SEEN_AS[entry["kind"]]),
        "axes": list(entry["axes"]),
        "size": 1.0,
        "observable": 1.0,
        "parameters": {},
    }


def main() -> None:
    """Run what is missing, then write and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machines", type=int, default=20, help="drawn beside the default one")
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of machines, 0: the default")
    parser.add_argument("--out", type=Path, default=Path("out/showcase"))
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    given = parser.parse_args()
    store = given.out / "results.jsonl"
    given.out.mkdir(parents=True, exist_ok=True)
    lines: list[Line] = []
    if store.exists():
        lines = [json.loads(text) for text in store.read_text(encoding="utf-8").splitlines()]
    key = {"seed": given.seed, "machines": given.machines, "commit": provenance()["commit"]}
    # a failure is tried again; its row stands until then
    lines = [e for e in lines if {k: e[k] for k in key} == key and "error" not in e]
    done = {line["number"] for line in lines}
    numbers = range(given.machines + 1) if given.only is None else given.only
    for number in (n for n in numbers if n not in done):
        try:
            line = {**key, **show(number, given.seed, given.machines, given.out)}
        except Exception as error:  # a failure is a row of the table
            traceback.print_exc()
            hidden = drawn(given.seed, number, given.machines) if number else ()
            line = {**key, "number": number, "hidden": [vars(h) for h in hidden]}
            line["error"] = f"{type(error).__name__}: {error}"
        line["judged"] = judged(line)
        _say(number, time.monotonic(), line["judged"])
        lines.append(line)
        with store.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    lines.sort(key=lambda entry: int(entry["number"]))
    print(json.dumps(lines) if given.json else table(lines))


if __name__ == "__main__":
    main()
