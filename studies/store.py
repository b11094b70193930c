"""Finished cases of a study, one JSON line each, so that it goes on where it stopped."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

Case = TypeVar("Case")


def read_lines(path: Path, parse: Callable[[dict[str, Any]], Case]) -> list[Case]:
    """Lines of a store; a last one without its end is cut off.

    ValueError, with the line, where the file holds anything else than `parse` takes.
    """
    content = path.read_bytes() if path.exists() else b""
    whole = content.rfind(b"\n") + 1
    rows = []
    for number, line in enumerate(content[:whole].splitlines(), start=1):
        try:
            rows.append(parse(json.loads(line)))
        except (ValueError, TypeError, KeyError) as error:
            raise ValueError(f"{path}:{number}: no case of this study ({error})") from None
    if whole < len(content):
        os.truncate(path, whole)
    return rows


def append_line(path: Path, row: Mapping[str, Any]) -> None:
    """Append a line; it is on the disk when this returns."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")
        file.flush()
        os.fsync(file.fileno())
