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
    found: Diagnosis,
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
    made = rebuild(machine_file, found, out, runs, held_out, options=logs, say=say)
    return with_rebuilt(found, made)


def with_rebuilt(found: Diagnosis, made: Rebuilt) -> Diagnosis:
    """What was found, without effects that the rebuilt model's held-out runs speak against."""
    effects = tuple(effect for effect in found.effects if effect.id not in made.withdrawn)
    notes = (*found.notes, *made.notes, *(f"not added: {text}" for text in made.left_out))
    if set(read_toml(made.machine_file)) - FRAME:
        return replace(
            found, effects=effects, machine=str(made.machine_file), shown=made.data(), notes=notes
        )
    notes = (*notes, "nothing was added: the machine file has no place for it, or it was withdrawn")
    verdict = found.verdict if effects or found.changed else "unknown"
    return replace(found, verdict=verdict, effects=effects, notes=notes)


FRAME = {"extends", "diagnosed"}
"""Keys of an extended machine file to which nothing was added."""
