"""A diagnosis asked in a process of its own, which knows nothing of the truth."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from studies.families import Files

Row = dict[str, Any]
SECONDS = 900.0
"""Longest time that an engine has for a case."""


def answered(engine: str, files: Files, seconds: float = SECONDS) -> Row:
    """What the engine says in its own process."""
    wanted = {
        "paths": [str(p) for p in files.paths],
        "test_paths": [str(p) for p in files.test_paths],
        "machine_file": str(files.machine_file),
    }
    with tempfile.TemporaryDirectory(prefix="answer-") as name:
        request, target = Path(name) / "request.json", Path(name) / "answer.json"
        request.write_text(json.dumps(wanted), encoding="utf-8")
        command = [sys.executable, "-m", "studies.mujoco.engines", engine]
        command += [str(request), str(target)]
        try:
            done = subprocess.run(command, timeout=seconds, capture_output=True, text=True)
            if target.exists():
                response: Row = json.loads(target.read_text(encoding="utf-8"))
                return response
            said = f"ended with {done.returncode}: {done.stderr[-2000:]}"
        except subprocess.TimeoutExpired:
            said = f"no answer within {seconds:.0f} s"
    empty = {"processor_seconds": None, "peak_bytes": None}
    return {"answer": None, "error": "failed", "text": said, **empty}
