"""Beyond the paper: what the model lacks, identified from the machine's own logs and added.

The machine runs three trajectories twice with fixed feedforward, and a fourth as held-out run.
The diagnosis reads these logs and the machine file, nothing else. The effects that it names enter
plant, feedforward and estimator, and the adaptive loop runs on the machine before and after.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py

from flexhex.diagnose.plots import AFTER, BEFORE
from flexhex.diagnose.rebuild import Rebuilt, rebuild
from flexhex.diagnose.titles import capital
from flexhex.diagnose.view import remarks
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.diagnosis.result.verdict import Diagnosis, Named
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine_file import truth_file
from flexhex.output.plots import Figure, broken, figure, of_joint, per_joint, trace
from flexhex.output.progress import Progress
from flexhex.output.tables import Column
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import Case, table_cases, whole_moves
from flexhex.simulation.runs import side_by_side
from flexhex.ssp.executor import run as execute
from flexhex.ssp.formats.hdf5 import stored
from flexhex.ssp.results import Result

FITTED, HELD_OUT, PASSES = ("a", "b", "c"), ("z",), (1, 2)
SECONDS = 12.0
"""Length of a logged run [s], without settling."""
STEPS = 5
"""Steps that a diagnosis reports."""
CHANNELS = {
    "theta": ("plant.theta", "rad"),
    "tau_meas": ("plant.tau_meas", "N m"),
    "tau": ("feedback.tau", "N m"),
    "r": ("reference.r", "rad"),
}
MILLI = 1e3
DOTTED: dict[str, Any] = {"mode": "lines+markers", "marker": {"size": 3}}
"""Marks at the bins of a line: one between two empty bins is seen, too."""
COLUMNS = (
    Column("model", "model"),
    Column("e", "e", "µrad", ".2f"),
    Column("tau_fb", "τ_FB", "mN m", ".2f"),
    Column("residual", "residual of the held-out runs", "mN m", ".2f"),
    Column("noise", "its non-repeatable part", "mN m", ".2f"),
)


@dataclass(frozen=True)
class Missing:
    """The diagnosis, and the extended model; rebuilt is None where no effect was named."""

    diagnosis: Diagnosis
    rebuilt: Rebuilt | None

    @property
    def sentence(self) -> str:
        """The verdict with its confidence."""
        return verdict(self.diagnosis)

    @property
    def notes(self) -> str:
        """What else the diagnosis says, as sentences."""
        return " ".join(f"{capital(note)}." for note in remarks(self.diagnosis))

    @property
    def names(self) -> list[dict[str, str]]:
        """Effects by title, axes, values and indistinguishable ones, for the report."""
        return [
            {
                "title": effect.title,
                "axes": ", ".join(map(str, effect.axes)) or "all",
                "rivals": ", ".join(effect.rivals),
                "values": _values(effect),
            }
            for effect in self.diagnosis.effects
        ]


def _values(effect: Named) -> str:
    """Shapes of an effect on its first axis, or its gains where it has no shape."""
    shapes = [shape.name for shape in library()[effect.id].shapes]
    first = [estimates for axis, estimates in effect.parts if axis == effect.parts[0][0]]
    texts = []
    for name in shapes or first[0]:
        values = ", ".join(f"{estimates[name].value:.4g}" for estimates in first)
        unit = first[0][name].unit
        turns = (name, unit) == ("order", "1/rad")
        texts.append(f"{values} periods a turn" if turns else f"{name} {values} {unit}")
    return "; ".join(texts)


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Missing:
    """Log, diagnose, extend the model, run again. UsageError for a machine without a truth file."""
    if not builder.has_truth:
        raise UsageError(
            f"--only missing: {builder.machine_file} has no truth file, so the simulated machine is"
            " its model, which lacks nothing: copy machines/tflex-truth.toml to"
            f" {truth_file(builder.machine_file)}"
        )
    seconds = whole_moves(builder.machine, 8.0 if quick else SECONDS)
    fixed = table_cases(builder.machine, fit.p, seconds, fit.std)[1]
    runs, held_out = record(builder, fixed, builder.out / "runs" / "missing", progress)
    progress.stage("diagnosing what the model lacks", STEPS, "steps")
    diagnosis = diagnose(runs, held_out, builder.machine_file, Options(), progress.steps)
    if not diagnosis.effects:
        return Missing(diagnosis, None)
    progress.stage("building the extended model and running the loop again")
    out = builder.out / "missing"
    return Missing(diagnosis, rebuild(builder.machine_file, diagnosis, out, runs, held_out))


def record(
    builder: Builder, fixed: Case, out: Path, progress: Progress
) -> tuple[list[Path], list[Path]]:
    """Logs of all runs as HDF5 files in `out`: those to fit to, and the held-out ones."""
    description, signals = builder.case(fixed), [signal for signal, _ in CHANNELS.values()]
    out.mkdir(parents=True, exist_ok=True)

    def one(name: tuple[str, int]) -> Path:
        trajectory, number = name
        # seeds that no other experiment has: the logged motions are nobody else's
        seed = zlib.crc32(f"missing {trajectory}".encode()) % 2**20
        seeds = {"reference.seed": float(seed), "plant.seed": float(seed + number)}
        result = execute(
            description,
            fixed.duration,
            signals=signals,
            parameters=seeds,
            progress=progress.case(fixed),
            timing=False,
        )
        return write_log(result, out / f"{trajectory}{number}.h5", trajectory, number)

    names = [(t, k) for t in (*FITTED, *HELD_OUT) for k in PASSES]
    paths = side_by_side(names, one, progress)
    count = len(FITTED) * len(PASSES)
    return paths[:count], paths[count:]


def write_log(result: Result, path: Path, trajectory: str, number: int) -> Path:
    """A pass of a trajectory as the diagnosis reads it (HDF5); whole when it is there."""
    partial = path.with_name("." + path.name)
    with h5py.File(partial, "w") as file:
        stored(file, "time", result.time("plant.theta")).attrs["unit"] = "s"
        for name, (signal, unit) in CHANNELS.items():
            stored(file, name, result[signal]).attrs["unit"] = unit
        file.attrs.update({"run": path.stem, "trajectory": trajectory, "pass": str(number)})
    return partial.rename(path)


def rows(result: Missing) -> list[dict[str, Any]]:
    """Adaptive loop on the machine, original and extended model: e [urad], tau_FB, residual of the
    held-out runs and its non-repeatable part [mN m]."""
    residual = result.diagnosis.residual.data()
    loops = result.rebuilt.loops.get("machine") if result.rebuilt else None
    listed = []
    for k, (title, key) in enumerate((("original", "before"), ("extended", "after"))):
        tracked = loops[k] if loops else None
        listed.append(
            {
                "model": title,
                "e": tracked.e if tracked else None,
                "tau_fb": MILLI * tracked.tau_fb if tracked else None,
                "residual": MILLI * residual[key] if residual[key] else None,
                "noise": MILLI * residual["non_repeatable"] if residual["non_repeatable"] else None,
            }
        )
    return listed


def data(result: Missing) -> dict[str, Any]:
    """For `--json`: the rows, the diagnosis, and what was built from it."""
    rebuilt = result.rebuilt.data() if result.rebuilt else None
    return {"rows": rows(result), "diagnosis": result.diagnosis.data(), "shown": rebuilt}


def figures(result: Missing) -> dict[str, Figure]:
    """The repeatable residual over the angle, before and after, one joint at a time."""
    lines = [
        of_joint(m.axis, trace(*broken(m.centre, MILLI * values), name, colour, **DOTTED))
        for m in result.diagnosis.maps
        if m.over == "angle"
        for values, name, colour in (
            (m.before, "original", BEFORE),
            (m.after, "extended", AFTER),
        )
    ]
    if not lines:
        return {}
    title = "Repeatable residual of joint {joint}"
    drawn = figure(title, "angle [rad]", "torque [mN m]", lines, height=300)
    return {"missing": per_joint(drawn)}
