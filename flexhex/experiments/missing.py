"""Beyond the paper: what the model lacks, found from the machine's own logs and added.

The machine runs three trajectories twice with fixed feedforward; a fourth is kept apart. The
diagnosis sees these logs and the machine file, nothing else. What it names enters plant,
feedforward and estimator, and the adaptive loop runs on the machine before and after.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flexhex.diagnose.rebuild import Rebuilt, rebuild
from flexhex.diagnosis.identify import Fit
from flexhex.diagnosis.verdict import Diagnosis, Map, Named
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import library
from flexhex.output.plots import Figure, figure, trace
from flexhex.output.progress import Progress
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import Case, table_cases, whole_moves
from flexhex.simulation.runs import WORKERS
from flexhex.ssp.executor import run as execute
from flexhex.ssp.results import Result

FITTED, LOCKED, PASSES = ("a", "b", "c"), ("z",), (1, 2)
SECONDS = 12.0
"""Length of a logged run [s], without settling."""
CHANNELS = {
    "theta": ("plant.theta", "rad"),
    "tau_meas": ("plant.tau_meas", "N m"),
    "tau": ("feedback.tau", "N m"),
    "r": ("reference.r", "rad"),
}
MILLI = 1e3


@dataclass(frozen=True)
class Missing:
    """What was found, and the model with it; rebuilt is None where nothing was."""

    found: Diagnosis
    rebuilt: Rebuilt | None

    @property
    def names(self) -> list[dict[str, str]]:
        """Effects as (title, axes, rivals), for the report."""
        return [
            {
                "title": effect.title,
                "axes": ", ".join(map(str, effect.axes)) or "all",
                "rivals": ", ".join(effect.rivals),
                "values": _values(effect),
            }
            for effect in self.found.effects
        ]


def _values(effect: Named) -> str:
    """Shapes of an effect on its first axis, or its gains where it has no shape."""
    shapes = [shape.name for shape in library()[effect.id].shapes]
    first = [estimates for axis, estimates in effect.parts if axis == effect.parts[0][0]]
    found = []
    for name in shapes or first[0]:
        values = ", ".join(f"{estimates[name].value:.4g}" for estimates in first)
        found.append(f"{name} {values} {first[0][name].unit}")
    return "; ".join(found)


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Missing:
    """Log, diagnose, add, close the loop."""
    seconds = whole_moves(builder.machine, 8.0 if quick else SECONDS)
    fixed = table_cases(builder.machine, fit.p, seconds, fit.std)[1]
    runs, locked = record(builder, fixed, builder.out / "runs" / "missing", progress)
    progress.stage("looking for what the model lacks")
    found = diagnose(runs, locked, builder.machine_file, Options(confidence=0))
    if not found.effects:
        return Missing(found, None)
    progress.stage("adding it, and closing the loop again")
    out = builder.out / "missing"
    return Missing(found, rebuild(builder.machine_file, found, out, runs, locked))


def record(
    builder: Builder, fixed: Case, out: Path, progress: Progress
) -> tuple[list[Path], list[Path]]:
    """Logs of all runs as HDF5 files in `out`: those to fit to, and the locked ones."""
    description, wanted = builder.case(fixed), [signal for signal, _ in CHANNELS.values()]
    out.mkdir(parents=True, exist_ok=True)

    def one(trajectory: str, number: int) -> Path:
        # seeds that no other experiment has: the logged motions are nobody else's
        seed = zlib.crc32(f"missing {trajectory}".encode()) % 2**20
        seeds = {"reference.seed": float(seed), "plant.seed": float(seed + number)}
        advance = progress.case(fixed)
        result = execute(
            description, fixed.duration, signals=wanted, parameters=seeds, progress=advance
        )
        return write_log(result, out / f"{trajectory}{number}.h5", trajectory, number)

    names = [(t, k) for t in (*FITTED, *LOCKED) for k in PASSES]
    with ThreadPoolExecutor(WORKERS) as pool:
        paths = list(pool.map(lambda name: one(*name), names))
    count = len(FITTED) * len(PASSES)
    return paths[:count], paths[count:]


def write_log(result: Result, path: Path, trajectory: str, number: int) -> Path:
    """A pass of a trajectory as the diagnosis reads it (HDF5); whole when it is there."""
    partial = path.with_name("." + path.name)
    with h5py.File(partial, "w") as file:
        file["time"] = result.time("plant.theta")
        file["time"].attrs["unit"] = "s"
        for name, (signal, unit) in CHANNELS.items():
            file[name] = result[signal]
            file[name].attrs["unit"] = unit
        file.attrs.update({"run": path.stem, "trajectory": trajectory, "pass": str(number)})
    return partial.rename(path)


def rows(result: Missing) -> list[dict[str, Any]]:
    """Adaptive loop on the machine, model as it was and extended: e [urad], tau_FB and the gap
    of the locked runs with its floor [mN m]."""
    gap = result.found.gap.data()
    loops = result.rebuilt.loops.get("machine") if result.rebuilt else None
    listed = []
    for k, (title, key) in enumerate((("as it was", "before"), ("extended", "after"))):
        tracked = loops[k] if loops else None
        listed.append(
            {
                "model": title,
                "e [µrad]": tracked.e if tracked else float("nan"),
                "tau_FB [mN m]": MILLI * tracked.tau_fb if tracked else float("nan"),
                "gap of locked runs [mN m]": MILLI * (gap[key] or float("nan")),
                "its floor [mN m]": MILLI * (gap["floor"] or float("nan")),
            }
        )
    return listed


def data(result: Missing) -> dict[str, Any]:
    """For `--json`: the rows, the diagnosis, and what was built from it."""
    rebuilt = result.rebuilt.data() if result.rebuilt else None
    return {"rows": rows(result), "diagnosis": result.found.data(), "shown": rebuilt}


def figures(result: Missing) -> dict[str, Figure]:
    """What repeats of the residual over the angle, before and after, axis by axis."""
    shown = [m for m in result.found.maps if m.over == "angle"]
    worst = sorted(shown, key=lambda m: -float(np.abs(m.before).max()))[:2]
    return {f"missing-{m.axis}": _map(m) for m in sorted(worst, key=lambda m: m.axis)}


def _map(shown: Map) -> Figure:
    lines: Sequence[Any] = [
        trace(shown.centre, MILLI * shown.before, "as it was", "#c33"),
        trace(shown.centre, MILLI * shown.after, "extended", "#1f6fb2"),
    ]
    title = f"What repeats of the difference between machine and model, axis {shown.axis}"
    return figure(title, "angle [rad]", "torque [mN m]", list(lines), height=300)
