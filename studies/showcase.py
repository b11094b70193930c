"""`python -m studies.showcase`: what machines hide, found from their logs and added.

Machine 0 is the default one; the others are drawn from seeds (`showcase_machines.py`). For each:
logs of machine.fmu under the fixed feedforward, `diagnose`, the extended model built, the adaptive
loop on machine.fmu before and after. Finished machines are lines of OUT/results.jsonl and are not
run again; the table goes to OUT/table.md.
"""

from __future__ import annotations

import argparse
import json
import shutil
import time
import traceback
from collections.abc import Sequence
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
from studies.showcase_machines import NEAR, SEEN_AS, drawn, write_machine

DEFAULT = Path("machines/tflex.toml")
Line = dict[str, Any]


def record(machine_file: Path, out: Path, seed: int) -> tuple[list[Path], list[Path]]:
    """Logs of the warm machine for the diagnosis, and locked ones, as HDF5 files in `out`.

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
    began, folder = time.monotonic(), out / f"{number:02d}"
    hidden = drawn(seed, number, machines) if number else ()
    own = 100 * seed + number
    machine_file = write_machine(DEFAULT, folder, hidden, own) if number else DEFAULT
    line: Line = {"number": number, "seed": seed, "machines": machines}
    line["hidden"] = [vars(h) for h in hidden] if number else _default_hidden()
    runs, locked = record(machine_file, folder, own)
    _say(number, began, "recorded")
    found = diagnose(runs, locked, machine_file, Options(confidence=0))
    _say(number, began, f"{found.verdict}: {_names(found.data()['effects'])}")
    line["diagnosis"] = found.data()
    for sub in ("model", "model/before"):
        _share_cache(folder / sub)
    made = rebuild(machine_file, found, folder / "model", runs, locked)
    line["shown"] = made.data()
    line["minutes"] = (time.monotonic() - began) / 60
    for path in (*runs, *locked):
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
    print(f"machine {number}, {time.monotonic() - began:.0f} s: {text}", flush=True)


def _names(effects: Sequence[Line]) -> str:
    return "; ".join(
        f"{e['id']} {','.join(map(str, e['axes']))}"
        + (f" (or {', '.join(e['rivals'])})" if e["rivals"] else "")
        for e in effects
    )


def judged(line: Line) -> str:
    """right, in a set, near (see `NEAR`), partly, missed, wrong; right for what is outside is to
    name nothing."""
    if "error" in line:
        return "failed"
    near = {name: ids for kind, names in NEAR.items() for name in names for ids in SEEN_AS[kind]}
    kinds = {h["kind"] for h in line["hidden"]}
    said_near = {e["id"] for e in line["diagnosis"]["effects"]} & set(near)
    if said_near and kinds & set(NEAR):
        effects = [{**e, "id": near.get(e["id"], e["id"])} for e in line["diagnosis"]["effects"]]
        found = judged({**line, "hidden": line["hidden"], "diagnosis": {"effects": effects}})
        return found.replace("right", "near")
    wanted = [set(SEEN_AS[h["kind"]]) for h in line["hidden"]]
    said = [{e["id"], *e["rivals"]} for e in line["diagnosis"]["effects"]]
    alone = [{e["id"]} for e in line["diagnosis"]["effects"]]
    inside = [ids for ids in wanted if ids]
    if not inside:
        return "right" if not said else "wrong"
    wrong = [s for s in said if not any(s & ids for ids in inside)]
    hit = [ids for ids in inside if any(s & ids for s in said)]
    if wrong:
        return "one wrong" if hit else "wrong"
    if len(hit) < len(inside):
        return "partly" if hit else "missed"
    return "right" if all(any(s & ids for s in alone) for ids in inside) else "right, in a set"


def table(lines: Sequence[Line]) -> str:
    """All machines as a markdown table, failures too."""
    head = (
        "machine",
        "hidden (axes, N m)",
        "verdict and names",
        "judged",
        "gap of locked runs [mN m]: base, extended, floor",
        "simulated gap [mN m]",
        "e [µrad] on the machine",
        "τ_FB [mN m]",
    )
    rows = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for line in sorted(lines, key=lambda entry: int(entry["number"])):
        rows.append("| " + " | ".join(_row(line)) + " |")
    return "\n".join(rows) + "\n"


def _row(line: Line) -> list[str]:
    hidden = "; ".join(
        f"{h['kind']} {','.join(map(str, h['axes']))} {h['size']:.3f}" for h in line["hidden"]
    )
    name = str(line["number"]) if line["number"] else "default"
    if "error" in line:
        return [
            name,
            hidden,
            " ".join(line["error"].replace("|", "/").split())[:300],
            "failed",
            "",
            "",
            "",
            "",
        ]
    found, shown = line["diagnosis"], line["shown"]
    gap = found["gap"]
    sums = [_rms(shown["simulation_gap"], key) for key in ("before", "after")]
    loop = shown["closed_loop"]["machine"]
    names = _names(found["effects"])
    if found["changed"]:
        names += f"; changed {', '.join(c['parameter'] for c in found['changed'])}"
    names += f" (withdrawn: {', '.join(shown['withdrawn'])})" if shown["withdrawn"] else ""
    return [
        name,
        hidden,
        f"{found['verdict']}: {names}",
        judged(line),
        " ".join(f"{1e3 * gap[key]:.2f}" for key in ("before", "after", "floor")),
        f"{sums[0]:.2f} → {sums[1]:.2f}",
        f"{loop['before']['e']:.1f} → {loop['after']['e']:.1f}",
        f"{1e3 * loop['before']['tau_fb']:.2f} → {1e3 * loop['after']['tau_fb']:.2f}",
    ]


def _rms(gaps: Line, key: str) -> float:
    values = [v**2 for gap in gaps.values() for v in gap[key]]
    return float(1e3 * (sum(values) / max(len(values), 1)) ** 0.5)


def main() -> None:
    """Run what is missing, then write and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machines", type=int, default=20, help="drawn beside the default one")
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of machines, 0: the default")
    parser.add_argument("--out", type=Path, default=Path("out/showcase"))
    given = parser.parse_args()
    store = given.out / "results.jsonl"
    given.out.mkdir(parents=True, exist_ok=True)
    lines: list[Line] = []
    if store.exists():
        lines = [json.loads(text) for text in store.read_text(encoding="utf-8").splitlines()]
    key = {"seed": given.seed, "machines": given.machines}
    # a failure is tried again; its row stands until then
    lines = [e for e in lines if {k: e[k] for k in key} == key and "error" not in e]
    done = {line["number"] for line in lines}
    numbers = range(given.machines + 1) if given.only is None else given.only
    for number in (n for n in numbers if n not in done):
        try:
            line = show(number, given.seed, given.machines, given.out)
        except Exception as error:  # a failure is a row of the table
            traceback.print_exc()
            hidden = drawn(given.seed, number, given.machines) if number else ()
            line = {**key, "number": number, "hidden": [vars(h) for h in hidden]}
            line["error"] = f"{type(error).__name__}: {error}"
        lines.append(line)
        with store.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        (given.out / "table.md").write_text(table(lines), encoding="utf-8")
    print(table(lines))


if __name__ == "__main__":
    main()
