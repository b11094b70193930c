"""What was found, added: a machine file that extends the user's own, and the FMUs built from it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from diagnosis.verdict import Diagnosis, Estimate, Named
from fmus.common.errors import MachineError
from fmus.common.machine_file import load_machine, machine_data

BANNER = """\
# Written by flexhex diagnose: the machine of {base} with the effects that measured runs show.
# The file it extends is unchanged. Runs: {runs}
"""


def add(
    found: Diagnosis, machine_file: Path, out: Path, say: Callable[[str], None] = lambda text: None
) -> Diagnosis:
    """Write OUT/NAME-extended.toml, build its FMUs and system descriptions into OUT.

    Parameters that changed are not written: a note says so. Raises MachineError when what was
    found makes no valid machine, BuildError when its code does not build.
    """
    from flexhex.build import Builder

    path = out / f"{machine_file.stem}-extended.toml"
    if not found.effects:
        return replace(found, notes=(*found.notes, *_by_hand(found, machine_file)))
    if path.resolve() == machine_file.resolve():
        raise MachineError(f"{path}: would overwrite the machine file: give another --out")
    out.mkdir(parents=True, exist_ok=True)
    path.write_text(extended(found, machine_file, path), encoding="utf-8")
    load_machine(path)
    Builder(path, out, say).systems()
    notes = (*found.notes, *_by_hand(found, machine_file))
    return replace(found, machine=str(path), notes=notes)


def _by_hand(found: Diagnosis, machine_file: Path) -> tuple[str, ...]:
    if not found.changed:
        return ()
    names = ", ".join(change.parameter for change in found.changed)
    return (f"{names}: write the new values into {machine_file.name} by hand",)


def extended(found: Diagnosis, machine_file: Path, path: Path) -> str:
    """Text of a machine file at `path` that has the effects of another one and those found."""
    base = Path(os.path.relpath(machine_file.resolve(), path.resolve().parent)).as_posix()
    head = BANNER.format(base=base, runs=", ".join(Path(run).name for run in found.runs))
    before = machine_data(machine_file).get("effects", [])
    entries = [*before, *(entry for effect in found.effects for entry in added(effect))]
    return f"{head}extends = {json.dumps(base)}\n" + "".join(map(_text, entries))


def added(effect: Named) -> list[dict[str, Any]]:
    """Entries of `[[effects]]`: one for each axis and shape."""
    entries = []
    parts = effect.parts or (((effect.axes or (0,))[0], effect.parameters),)
    for axis, estimates in parts:
        tables = {name: _table(estimate) for name, estimate in estimates.items()}
        entry: dict[str, Any] = {"id": effect.id, **({"axes": [axis]} if axis else {})}
        entries.append({**entry, "parameters": tables})
    return entries


def _table(e: Estimate) -> dict[str, Any]:
    low, high = e.ci95
    known = math.isfinite(low) and math.isfinite(high) and high > low
    interval = {"source": "diagnosed", "ci95": [low, high]} if known else {"source": "assumed"}
    return {"value": e.value, "unit": e.unit, **interval}


def _text(entry: Mapping[str, Any]) -> str:
    lines = ["", "[[effects]]", f"id = {json.dumps(entry['id'])}"]
    if "axes" in entry:
        lines.append(f"axes = {json.dumps(entry['axes'])}")
    lines.append("[effects.parameters]")
    for name, table in entry["parameters"].items():
        inner = ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items())
        lines.append(f"{name} = {{ {inner} }}")
    return "\n".join(lines) + "\n"
