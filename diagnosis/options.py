"""What a user asks of a diagnosis beside runs and machine file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from diagnosis.logs import Options as LogOptions
from diagnosis.verdict import Diagnosis

BASES = ("hexapod", "axis", "schunk")
"""Base models: the machine of a machine file, single axes, a rigid-joint arm."""


def never(found: Diagnosis) -> bool:
    """Nothing is added."""
    return False


@dataclass(frozen=True)
class Options:
    """base: one of BASES; out: folder for all that is written; logs: how to read them.

    agree: told what was found, says whether it is to be added to a copy of the machine file.
    """

    base: str = "hexapod"
    out: Path = Path("out/diagnose")
    logs: LogOptions = field(default_factory=LogOptions)
    agree: Callable[[Diagnosis], bool] = never
