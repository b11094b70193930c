"""Whether an FMU's binary keeps what its description promises: tried in a child process."""

from __future__ import annotations

import json
import math
import os
import platform
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from flexhex.check.subject import Scalar, Subject, parsed

PATIENCE = 60.0
"""Seconds until a trial counts as hanging."""
SUFFIXES = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Boolean": "Boolean",
}
"""FMI's functions by type of variable."""
SYSTEMS = {"Linux": ("linux", "so"), "Darwin": ("darwin", "dylib"), "Windows": ("win", "dll")}


def library_name(subject: Subject) -> str | None:
    """The binary for this computer in the archive, None without one."""
    system, suffix = SYSTEMS.get(platform.system(), ("", ""))
    element = subject.cosimulation
    if not system or element is None:
        return None
    arm = platform.machine() in ("aarch64", "arm64")
    folders = [f"aarch64-{system}"] if arm else [f"{system}64", f"x86_64-{system}"]
    names = (f"binaries/{f}/{element.get('modelIdentifier')}.{suffix}" for f in folders)
    return next((name for name in names if name in subject.names), None)


def binary(subject: Subject) -> list[str]:
    """Complaints about the binary; none when there is none for this computer.

    One that needs a tool to execute is not tried: the tool may be absent here.
    """
    name, element = library_name(subject), subject.cosimulation
    if name is None or element is None or element.get("needsExecutionTool") == "true":
        return []
    with tempfile.TemporaryDirectory() as folder, subject.archive() as archive:
        archive.extractall(folder)
        plan = make_plan(subject, Path(folder), name)
        return _tried(plan)


def make_plan(subject: Subject, folder: Path, name: str) -> dict[str, Any]:
    """What the child needs to know: declared flags, variables, dependencies, a step size."""
    element = subject.cosimulation
    given = () if element is None else element.attrib.items()
    flags = {str(k): v not in ("false", "0") for k, v in given}
    experiment = subject.root.find("DefaultExperiment")
    timing = {} if experiment is None else {str(k): str(v) for k, v in experiment.attrib.items()}
    listed = [_described(v, subject) for v in subject.variables if v.kind in SUFFIXES]
    Ts = next((v["start"] for v in listed if v["name"] == "Ts" and subject.ours), 0.0)
    return {
        "library": str(folder / name),
        "guid": subject.root.get("guid", ""),
        "resources": (folder / "resources").as_uri(),
        "ours": subject.ours,
        "flags": flags,
        "categories": [c.get("name") for c in subject.root.iterfind("LogCategories/Category")],
        "variables": listed,
        "start": _usable(parsed(timing.get("startTime"), 0.0), 0.0),
        "step": max(_usable(parsed(timing.get("stepSize"), 0.01), 0.01), Ts),
        "dependencies": _dependencies(subject, "Outputs"),
        "initial": _dependencies(subject, "InitialUnknowns"),
    }


def _usable(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise


def place(v: Scalar) -> tuple[str, int]:
    """FMI's function for a variable and its value reference."""
    return SUFFIXES[v.kind], int(v.reference) if v.reference.isdigit() else 0


def _described(v: Scalar, subject: Subject) -> dict[str, Any]:
    start, low, high = (v.number(key) for key in ("start", "min", "max"))
    if v.kind == "Enumeration":
        items = subject.items(v)
        low, high = (low, high) if math.isfinite(low) else (min(items), max(items))
    elif v.kind == "Boolean":
        low, high = 0.0, 1.0
    return {
        "name": v.name,
        "type": SUFFIXES[v.kind],
        "reference": place(v),
        "causality": v.causality,
        "variability": v.variability,
        "start": start if math.isfinite(start) else 0.0,
        "min": low if math.isfinite(low) else None,
        "max": high if math.isfinite(high) else None,
    }


def _dependencies(subject: Subject, part: str) -> dict[str, list[str] | None]:
    """Output -> names that it depends on; None where the description does not say."""
    names = {str(v.index): v.name for v in subject.variables}
    dependencies: dict[str, list[str] | None] = {}
    for element in subject.root.iterfind(f"ModelStructure/{part}/Unknown"):
        words = element.get("dependencies")
        listed = None if words is None else [names.get(w, "") for w in words.split()]
        dependencies[names.get(element.get("index", ""), "")] = listed
    return dependencies


def exercised(plan: dict[str, Any]) -> tuple[list[tuple[str, Any]], str]:
    """What the child said, as (kind, value), and how it ended: "" when well."""
    command = [sys.executable, "-m", "flexhex.check.exercise"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    ended = ""
    try:
        done = subprocess.run(
            command,
            input=json.dumps(plan),
            capture_output=True,
            text=True,
            env=environment,
            timeout=PATIENCE,
            check=False,
        )
        output = done.stdout
        if done.returncode:
            ended = _reason(done.returncode, done.stderr)
    except subprocess.TimeoutExpired as error:
        output = error.stdout.decode() if isinstance(error.stdout, bytes) else error.stdout or ""
        ended = f"does not come back within {PATIENCE:g} s"
    said = []
    for line in output.splitlines():
        try:
            kind, value = json.loads(line)
        except (ValueError, TypeError):  # a library that prints
            continue
        said.append((kind, value))
    return said, ended


def _tried(plan: dict[str, Any]) -> list[str]:
    """Run the child; a crash or a hang is a complaint that names what was tried."""
    said, ended = exercised(plan)
    complaints = [f"binary: {text}" for kind, text in said if kind == "complaint"]
    doing = next((text for kind, text in reversed(said) if kind == "doing"), "starting")
    return [*complaints, f"binary: {ended}, while tried: {doing}"] if ended else complaints


def _reason(code: int, stderr: str) -> str:
    if code < 0:
        return f"crashes ({signal.Signals(-code).name})"
    lines = stderr.strip().splitlines()
    return f"ends the process with {code}" + (f" ({lines[-1]})" if lines else "")
