"""A machine file against the published row with feedback only: how assumed values were tuned.

    python -m studies.fidelity [MACHINE.toml] [--seeds 1,2,3] [--duration S] [--out DIR] [--json]

Copy tflex.toml, change an assumed value, run this on the copy: the eight columns for each
trajectory, how far their mean squares are from what is published, and whether the machine still
makes sense as a body. The machine is its model: nothing of a truth file takes part.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import FlexhexError, UsageError
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.sections import Body
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.output.tables import Column, console, table
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, Case, table_cases, whole_moves
from flexhex.simulation.metrics import KEYS, figure_columns, figures
from flexhex.simulation.published import published
from flexhex.ssp.executor import run

Array = NDArray[np.float64]
MACHINE_FILE = Path("machines") / "tflex.toml"
OUT = Path("out") / "fidelity"
SIGNALS = ("plant.theta", "plant.end_stop", "feedback.e", "feedback.tau", "feedback.tau_fb")
WITHIN = 0.2
"""Largest deviation from a published figure that counts as met: trajectories differ by about it."""


@dataclass(frozen=True)
class Trajectory:
    """row (8,): the figures of `metrics.Figures`. Largest angle [rad] and torque [N m] of a motor;
    stopped: whether an end stop was reached."""

    row: tuple[float, ...]
    angle: float
    torque: float
    stopped: bool


def feedback_case(machine: Machine, duration: float) -> Case:
    """The case with feedback only, around the model, for a duration [s]."""
    case = table_cases(machine, base_parameters(machine), duration)[0]
    starts = {name: values for name, values in case.starts.items() if name != "plant"}
    return dataclasses.replace(case, plant="plant", starts=starts)


def trajectory(machine: Machine, ssp: Path, duration: float, seed: int) -> Trajectory:
    """Simulate the random trajectory of a seed."""
    parameters = {"reference.seed": float(seed)}
    result = run(ssp, duration, signals=SIGNALS, parameters=parameters, timing=False)
    signals = {name: result[name][result.time(name) > SETTLE] for name in SIGNALS}
    row = figures(
        machine, signals["plant.theta"], signals["feedback.e"], signals["feedback.tau_fb"]
    ).row()
    angle, torque = (float(np.abs(signals[name]).max()) for name in ("plant.theta", "feedback.tau"))
    return Trajectory(row, angle, torque, bool(signals["plant.end_stop"].any()))


def deviations(rows: Sequence[Sequence[float]], wanted: Sequence[float]) -> Array:
    """(8,): root of the mean square over trajectories, relative to what is published, less one."""
    return np.asarray(np.sqrt(np.mean(np.square(rows), axis=0)) / np.array(wanted) - 1.0)


def extents(body: Body) -> Array:
    """RMS distances (3,) [m] of a body's mass from its centre of mass, along the main axes.

    The integral of r r^T dm is tr(I) / 2 - I.
    """
    inertia = inertia_rows(body.Ic)
    spread = np.eye(3) * np.trace(inertia) / 2.0 - inertia
    return np.asarray(np.sqrt(np.linalg.eigvalsh(spread) / body.m))


def sense(machine: Machine, runs: Sequence[Trajectory]) -> dict[str, tuple[float, ...]]:
    """What has to stay within physical bounds: each figure, then its bound.

    Extents of the end-effector [m] beside the radius of its joints; largest angle beside the
    stroke [rad]; largest torque beside the drive's limit [N m].
    """
    joints = max(math.hypot(*r[:2]) for r in machine.platform.r_EP)
    return {
        "end-effector extent [m]": (float(extents(machine.platform.end_effector).max()), joints),
        "angle [rad]": (max(r.angle for r in runs), machine.geometry.stroke),
        "torque [N m]": (max(r.torque for r in runs), machine.drive.tau_max),
        "end stops reached": (float(sum(r.stopped for r in runs)), 0.0),
    }


def measured(
    machine_file: Path, out: Path, seconds: float | None, seeds: Sequence[int]
) -> dict[str, Any]:
    """Rows, deviations, physical bounds. UsageError where nothing is published."""
    known = published(MACHINE_FILE)
    if known is None:
        raise UsageError(f"{MACHINE_FILE}: no published row; run this at the repository's top")
    builder = Builder(machine_file, out)
    machine = builder.machine
    builder.check()
    builder.fmus()
    length = machine.reference.duration if seconds is None else whole_moves(machine, seconds)
    case = feedback_case(machine, length)
    ssp = builder.case(case)
    runs = [trajectory(machine, ssp, case.duration, seed) for seed in seeds]
    wanted = known.rows["feedback"]
    rows = [r.row for r in runs]
    return {
        "seeds": list(seeds),
        "seconds": length,
        "published": list(wanted),
        "rows": rows,
        "deviations": deviations(rows, wanted).tolist(),
        "sense": sense(machine, runs),
    }


def show(results: dict[str, Any]) -> None:
    """Tables for people, and the verdict."""
    columns = (Column("title", ""), *figure_columns())
    titles = ["published", *(f"seed {seed}" for seed in results["seeds"])]
    values = [results["published"], *results["rows"]]
    rows = [
        {"title": title} | dict(zip(KEYS, row, strict=True))
        for title, row in zip(titles, values, strict=True)
    ]
    out = console()
    out.print(table("feedback only", columns, rows))
    shares = dict(zip(KEYS, (f"{d:+.0%}" for d in results["deviations"]), strict=True))
    out.print(
        "mean square of the seeds against published:", ", ".join(map(" ".join, shares.items()))
    )
    for name, (value, bound) in results["sense"].items():
        out.print(f"{name}: {value:.3g}, at most {bound:.3g}: {'yes' if value <= bound else 'NO'}")


def main(arguments: list[str] | None = None) -> int:
    """0; 1 when a column is not within WITHIN or a bound is exceeded; 3 for mistakes."""
    parser = argparse.ArgumentParser(prog="studies.fidelity", description=__doc__)
    parser.add_argument("machine", nargs="?", type=Path, default=MACHINE_FILE)
    parser.add_argument("--out", type=Path, default=OUT, help="folder for what is built")
    parser.add_argument("--seeds", default="1,2,3", help="seeds of the trajectories")
    parser.add_argument("--duration", type=float, help="of each trajectory [s]")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    given = parser.parse_args(arguments)
    try:
        seeds = [int(seed) for seed in given.seeds.split(",")]
    except ValueError:
        parser.error(f"--seeds {given.seeds!r}: whole numbers with commas between, as 1,2,3")
    try:
        results = measured(given.machine, given.out, given.duration, seeds)
    except FlexhexError as error:
        print(f"studies.fidelity: {error}", file=sys.stderr)
        return 3
    if given.json:
        print(json.dumps(results))
    else:
        show(results)
    met = max(map(abs, results["deviations"])) <= WITHIN
    return 0 if met and all(value <= bound for value, bound in results["sense"].values()) else 1


if __name__ == "__main__":
    raise SystemExit(main())
