"""What was found, added: the extended model is built, replayed and run, the diagnosis says how."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from flexhex.diagnose.rebuild import Rebuilt, rebuild
from flexhex.diagnosis.logs import Options
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.fmus.common.machine_file import read_toml


def add(
    diagnosis: Diagnosis,
    machine_file: Path,
    out: Path,
    runs: Sequence[Path],
    held_out: Sequence[Path],
    logs: Options,
    say: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """The diagnosis with OUT/machine.toml, the residual of the rebuilt model and its closed loop.

    Raises MachineError, LogError or BuildError for what cannot be read or built.
    """
    rebuilt = rebuild(machine_file, diagnosis, out, runs, held_out, options=logs, say=say)
    return with_rebuilt(diagnosis, rebuilt)


def with_rebuilt(diagnosis: Diagnosis, rebuilt: Rebuilt) -> Diagnosis:
    """What was found, without effects that the rebuilt model's held-out runs speak against."""
    effects = tuple(effect for effect in diagnosis.effects if effect.id not in rebuilt.withdrawn)
    notes = (*diagnosis.notes, *rebuilt.notes, *(f"not added: {text}" for text in rebuilt.left_out))
    if set(read_toml(rebuilt.machine_file)) - FRAME:
        return replace(
            diagnosis,
            effects=effects,
            machine=str(rebuilt.machine_file),
            shown=rebuilt.data(),
            notes=notes,
        )
    notes = (*notes, "nothing was added: the machine file has no place for it, or it was withdrawn")
    verdict = diagnosis.verdict if effects or diagnosis.changed else "unknown"
    return replace(diagnosis, verdict=verdict, effects=effects, notes=notes)


FRAME = {"extends", "diagnosed"}
"""Keys of an extended machine file to which nothing was added."""
