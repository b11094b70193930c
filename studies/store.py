"""Finished cases of a study, so that it goes on where it stopped."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from studies.score import Score

Task = tuple[str, int]
"""Kind of case (seed, closed, machine) and its number."""


class Store:
    """Finished cases, one JSON line each; a last line without its end is cut off."""

    def __init__(self, path: Path) -> None:
        """ValueError, with the line, where the file holds anything else."""
        self.path = path
        self.done: dict[Task, Score] = {}
        content = path.read_bytes() if path.exists() else b""
        whole = content.rfind(b"\n") + 1
        for number, line in enumerate(content[:whole].splitlines(), start=1):
            try:
                row = json.loads(line)
                task, found = row.pop("task"), Score(**row)
            except (ValueError, TypeError, KeyError) as error:
                raise ValueError(f"{path}:{number}: no case of this study ({error})") from None
            self.done[task[0], task[1]] = _tuples(found)
        if whole < len(content):
            os.truncate(path, whole)

    def add(self, task: Task, found: Score) -> None:
        """Append a case; it is on the disk when this returns."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"task": task, **asdict(found)}) + "\n")
            file.flush()
            os.fsync(file.fileno())
        self.done[task] = found


def _tuples(s: Score) -> Score:
    """A score as read back, lists made tuples again."""
    values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in vars(s).items()}
    return Score(**values)
