"""What is kept of a command's answer."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from results import record


def test_files_of_the_repository_have_no_place_of_this_computer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record, "FOLDER", tmp_path)
    note = f"{record.ROOT}/examples/a.csv: short; /elsewhere/b.csv: long"
    path = record.write("kept", {"results": {"notes": [note]}})
    kept = json.loads(path.read_text(encoding="utf-8"))
    assert kept["results"]["notes"] == ["examples/a.csv: short; /elsewhere/b.csv: long"]
