"""Engines for the study: `engine(paths, test_paths, machine_file) -> answer`, as of --json.

`python -m studies.mujoco.engines MODULE:FUNCTION REQUEST ANSWER` runs one in its own process:
REQUEST is a JSON file with `paths`, `test_paths`, `machine_file`; ANSWER gets `answer`, `error`,
`processor_seconds`, `peak_bytes`. It knows nothing of the truth.
"""

from __future__ import annotations

import importlib
import json
import resource
import sys
import time
import tomllib
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

Engine = Callable[[Sequence[Path], Sequence[Path], Path], dict[str, Any]]


def load(name: str) -> Engine:
    """The function MODULE:FUNCTION. ValueError for another form."""
    module, _, function = name.partition(":")
    if not module or not function:
        raise ValueError(f"engine {name!r}: MODULE:FUNCTION is wanted")
    engine: Engine = getattr(importlib.import_module(module), function)
    return engine


def today(paths: Sequence[Path], test_paths: Sequence[Path], machine_file: Path) -> dict[str, Any]:
    """The engine as it is, with the base model that it has for such a machine.

    Axes and gantries: `axis`, which takes no file. Arms: its rigid arm, with the links, inertias
    and tolerances of the file. A hexapod: the file itself.
    """
    workflow: Any = importlib.import_module("flexhex.diagnosis.workflow")
    data = tomllib.loads(machine_file.read_text(encoding="utf-8"))
    kind = data.get("kind")
    base = {"arm": "arm", None: "hexapod"}.get(kind, "axis")
    options = workflow.Options(base=base)
    if kind == "arm":
        bases: Any = importlib.import_module("flexhex.diagnosis.basemodels.bases")
        cast(dict[str, Any], bases.BASES)["arm"] = lambda file, log: _arm(data, log["theta"].ts)
    answer: dict[str, Any] = workflow.diagnose_files(paths, test_paths, machine_file, options)
    return answer


def _arm(data: dict[str, Any], ts: float) -> Any:
    """Base model of an arm from its machine file."""
    arm: Any = importlib.import_module("flexhex.diagnosis.basemodels.arm")
    serial: Any = importlib.import_module("flexhex.diagnosis.basemodels.serial")
    spread, rows = data["tolerance_mass"], data["links"]
    links = tuple(
        serial.Link(tuple(r["at"]), tuple(r["rpy"]), r["mass"], tuple(r["centre"])) for r in rows
    )
    misplaced = data["tolerance_geometry"]
    described = serial.Arm(links, tuple(data["gravity"]), spread, misplaced)
    base = arm.RigidArmBase(described, ts)
    values = [value for row in rows for value in _ten(row)]
    linear = list(base.linear)
    for k, value in enumerate(values):
        body = values[10 * (k // 10) : 10 * (k // 10) + 10]
        group = body[:1] if k % 10 == 0 else body[1:4] if k % 10 < 4 else body[4:]
        size = spread * max(abs(v) for v in group)
        linear[k] = replace(linear[k], nominal=float(value), tolerance=float(size))
    for k, row in enumerate(rows, start=len(values)):
        rotor = float(row["armature"])
        linear[k] = replace(linear[k], nominal=rotor, tolerance=spread * rotor)
    base.linear = tuple(linear)
    return base


def _ten(row: dict[str, Any]) -> list[float]:
    """m, mc (3), J about the frame's origin: xx, xy, xz, yy, yz, zz."""
    m, c = row["mass"], np.array(row["centre"])
    xx, yy, zz, xy, xz, yz = row["inertia"]
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    J = own + m * (c @ c * np.eye(3) - np.outer(c, c))
    return [m, *(m * c), *(J[i, j] for i in range(3) for j in range(i, 3))]


def main(arguments: list[str]) -> int:
    """0, also where the engine failed: the answer file says so."""
    name, request, target = arguments
    wanted = json.loads(Path(request).read_text(encoding="utf-8"))
    paths, tests = ([Path(p) for p in wanted[key]] for key in ("paths", "test_paths"))
    engine, start = load(name), time.process_time()
    answer: dict[str, Any] | None = None
    error = text = ""
    try:
        answer = engine(paths, tests, Path(wanted["machine_file"]))
    except Exception as trouble:
        # an error class of the engine's own is a refusal, anything else a fault of it
        own = type(trouble).__module__.startswith(name.partition(".")[0])
        own = own or type(trouble).__module__.startswith("flexhex")
        error, text = ("refused" if own else "failed"), traceback.format_exc(limit=-3)
    result = {
        "answer": answer,
        "error": error,
        "text": text,
        "processor_seconds": time.process_time() - start,
        "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    }
    Path(target).write_text(json.dumps(result), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
