"""Figures of finished runs: one JSON line each, added as a run ends, read when a study goes on."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from flexhex.fmus.common.errors import LogError, UsageError


@dataclass(frozen=True)
class Scored:
    """Figures of one run after the settling time: e [rad], tau_fb [N m], RMS over all joints
    and samples; faults: samples with a fault; drawn: what was drawn for it."""

    key: str
    case: str
    number: int
    e: float
    tau_fb: float
    faults: int = 0
    drawn: Mapping[str, float] = field(default_factory=dict)


class Store:
    """A file of JSON lines. A last line without its end, left by a crash, is cut off."""

    def __init__(self, path: Path) -> None:
        """Read what is there; LogError for a file that holds anything else."""
        self.path = path
        self.done: dict[str, Scored] = {}
        content = path.read_bytes() if path.exists() else b""
        whole = content.rfind(b"\n") + 1
        for number, line in enumerate(content[:whole].splitlines(), start=1):
            scored = self._line(number, line)
            self.done[scored.key] = scored
        if whole < len(content):
            if whole == 0 and not content.startswith(b'{"key"'[: len(content)]):
                raise self._foreign(1)
            os.truncate(path, whole)

    def add(self, scored: Scored) -> None:
        """Append one run; it is on the disk when this returns."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        line = json.dumps(asdict(scored), allow_nan=False) + "\n"
        with self.path.open("a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self.done[scored.key] = scored

    def _line(self, number: int, line: bytes) -> Scored:
        try:
            scored = Scored(**json.loads(line))
            if math.isfinite(scored.e) and math.isfinite(scored.tau_fb):
                return scored
        except (ValueError, TypeError):
            pass
        raise self._foreign(number)

    def _foreign(self, number: int) -> LogError:
        return LogError(
            f"{self.path}:{number}: no run of flexhex study: take another --name,"
            " or delete that line"
        )


def file_name(name: str, ending: str) -> str:
    """`name.ending`; UsageError when the name could lead to another folder."""
    if not re.fullmatch(r"[\w][\w.+-]*", name):
        raise UsageError(f"--name {name!r}: letters, digits, - _ . + only, as in payload-1kg")
    return f"{name}.{ending}"
