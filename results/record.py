"""`python -m results.record NAME COMMAND...`: run a command that prints JSON, keep what it says.

results/NAME.json then holds `provenance` (command, commit, whether the code had changes that are
not committed, computer, date, minutes) and `results` (what the command printed).
"""

from __future__ import annotations

import json
import os
import platform
import resource
import shlex
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from flexhex.fmugen.compile import version

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "results"
NO_CODE = (":(exclude)*.md", ":(exclude)results/*.json")
"""Changes of these do not change what a command measures."""


def record(name: str, command: list[str]) -> Path:
    """Run the command; the results file. ValueError when it fails or prints no JSON."""
    began, before = time.monotonic(), provenance()
    program = [sys.executable if command[0] == "python" else command[0], *command[1:]]
    done = subprocess.run(program, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        printed = json.loads(done.stdout)
    except ValueError:
        raise ValueError(f"{shlex.join(command)}: exit {done.returncode}, no JSON") from None
    origin = {"command": shlex.join(command), "exit": done.returncode, **before}
    origin["minutes"] = round((time.monotonic() - began) / 60, 1)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    origin["processor_minutes"] = round((used.ru_utime + used.ru_stime) / 60, 1)
    return write(name, {"provenance": origin, "results": printed})


def write(name: str, content: dict[str, Any]) -> Path:
    """Keep the content as results/NAME.json, whole or not at all; files of the repository by their
    paths in it."""
    path = FOLDER / f"{name}.json"
    partial = path.with_suffix(".part")
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    text = text.replace(f"{ROOT}/", "")
    partial.write_text(text + "\n", encoding="utf-8")
    return partial.rename(path)


def provenance() -> dict[str, Any]:
    """Commit, uncommitted changes of code, computer, date."""
    changes = _git("status", "--porcelain", "--", ".", *NO_CODE)
    date = datetime.now(UTC).isoformat(timespec="seconds")
    return {"commit": _git("rev-parse", "HEAD"), "dirty": bool(changes)} | {
        "computer": computer(),
        "date": date,
    }


def computer() -> dict[str, Any]:
    """Processor, cores, load, compiler."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = names[0].partition(":")[2].strip() if names else cpu
    load = round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None
    return {"cpu": cpu, "cores": os.cpu_count(), "load": load, "compiler": version()}


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def main(arguments: list[str]) -> int:
    """0; 1 when the command gave nothing to keep; 2 for wrong use."""
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        print(f"wrote {record(arguments[0], arguments[1:])}")
    except ValueError as error:
        print(f"results.record: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
