"""Engines for the study: `engine(paths, test_paths, machine_file) -> answer`, as of --json.

`python -m studies.mujoco.engines MODULE:FUNCTION REQUEST ANSWER` runs one in its own process:
REQUEST is a JSON file with `paths`, `test_paths`, `machine_file`; ANSWER gets `answer`, `error`,
`processor_seconds`, `peak_bytes`. It knows nothing of the truth.
"""

from __future__ import annotations

import importlib
import json
import re
import resource
import sys
import tempfile
import time
import tomllib
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from studies.mujoco.machine import Link, Machine, Parts, mjcf, triple

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

    Axes and gantries: `axis`, which takes no file. Arms: that of robots' files, with the links,
    inertias and tolerances of the file. A hexapod: the file itself.
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
    """Base model of an arm from its machine file, by way of MJCF."""
    robots: Any = importlib.import_module("flexhex.diagnosis.basemodels.robots")
    files: Any = importlib.import_module("flexhex.diagnosis.basemodels.robot_file")
    places: Any = importlib.import_module("flexhex.diagnosis.basemodels.robot_geometry")
    tolerances: Any = importlib.import_module("flexhex.diagnosis.basemodels.tolerances")
    spread, misplaced = data["tolerance_mass"], data["tolerance_geometry"]
    links = tuple(Link(**row) for row in data["links"])
    n, gravity = len(links), triple(np.array(data["gravity"]))
    machine = Machine("arm", links, gravity, (0.0,) * n, (1.0,) * n, 1.0)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.xml"
        file.write_text(mjcf(machine, ts, Parts()), encoding="utf-8")
        robot = files.read_robot(file, [f"j{k + 1}" for k in range(n)], n)
    known = tolerances.RobotTolerance().model_copy(
        update={"inertia": spread, "geometry": misplaced, "gravity": misplaced}
    )
    base = robots.RobotBase(file, robot, known, ts)
    listed = [replace(k, name=_named(k.name), group=_named(k.group)) for k in base.linear]
    for first in range(0, 10 * n, 10):
        for part in (
            slice(first, first + 1),
            slice(first + 1, first + 4),
            slice(first + 4, first + 10),
        ):
            size = spread * max(abs(k.nominal) for k in listed[part])
            listed[part] = [replace(k, tolerance=size) for k in listed[part]]
    base.linear = tuple(listed)
    if base.geometry is not None:
        length = max(float(np.linalg.norm(link.at)) for link in links[1:] or links)
        errors = places.Placements(robot, files.pinocchio(), length, known)
        errors.known = tuple(
            replace(k, name=_named(k.name), group=_named(k.group)) for k in errors.known
        )
        base.geometry = errors
    return base


def _named(name: str) -> str:
    """`link[2].m`, as the truth calls what MJCF calls `b2.m`."""
    return re.sub(r"^b(\d+)\.", r"link[\1].", name)


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
