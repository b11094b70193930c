"""Fig. 2 of the paper: torque against angle in slow motion, the model over the measurement.

One actuator follows a slow triangle, the others hold. Measured torque and the torque that the
model predicts with the fitted parameters (all of Phi p: chi and the mechanism) pass the same
window. A straight line in the angle, fitted to each, is taken off: stiffness and offset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexhex.diagnosis.estimation.identify import Fit, regression
from flexhex.diagnosis.estimation.motion import MotionModel, SparseRegressor, smooth
from flexhex.diagnosis.logs import Log
from flexhex.fmus.filter.equations import hann
from flexhex.output.plots import Figure, figure, trace
from flexhex.output.progress import Progress
from flexhex.output.tables import Column
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, table_cases
from flexhex.simulation.metrics import rms
from flexhex.simulation.runs import Array, record, samples, variant
from flexhex.ssp.results import Result

SPEED, QUICK_SPEED, ROUNDING = 0.05, 0.15, 1.0
"""Triangle: rad/s between its corners, rad/s2 in them."""
CYCLES = 2
"""The first lets the hysteresis forget the start; from peak to peak one is shown."""
TRIANGLE = 1.0
POINTS = 1500
"""Samples of a branch that are kept: 0.3 mrad apart, a tenth of the finest cogging's radian."""
SIGNALS = ("plant.theta", "plant.tau_meas")
FORWARD, BACKWARD = "#1f6fb2", "#d1731d"
COLUMNS = (
    Column("name", ""),
    Column("measured", "measured", number=".4f"),
    Column("model", "model", number=".4f"),
    Column("unit", "unit"),
)


@dataclass(frozen=True)
class Branch:
    """One direction of the motion: theta (m,) [rad]; measured, model (m,) [N m], line removed."""

    theta: Array
    measured: Array
    model: Array


@dataclass(frozen=True)
class Hysteresis:
    """The loop of one actuator; lines are (offset [N m], slope [N m/rad]) that were removed."""

    actuator: int
    speed: float
    forward: Branch
    backward: Branch
    line_measured: tuple[float, float]
    line_model: tuple[float, float]

    @property
    def size(self) -> float:
        """RMS of the measured torque without its line [N m]."""
        return rms(np.concatenate([self.forward.measured, self.backward.measured]))

    @property
    def missed(self) -> float:
        """RMS of measurement minus model, lines removed [N m]."""
        both = (self.forward, self.backward)
        return rms(np.concatenate([b.measured - b.model for b in both]))

    def width(self, which: str) -> float:
        """Mean distance of the branches away from the turns [N m]: `measured` or `model`."""
        return float(_middle(self.forward, which) - _middle(self.backward, which))


def _middle(branch: Branch, which: str) -> float:
    inner = np.abs(branch.theta) < 0.7 * np.abs(branch.theta).max()
    grid = np.linspace(branch.theta[inner].min(), branch.theta[inner].max(), 400)
    order = np.argsort(branch.theta)
    return float(np.interp(grid, branch.theta[order], getattr(branch, which)[order]).mean())


def duration_of(amplitude: float, speed: float) -> float:
    """Whole seconds that hold the cycles, [rad] and [rad/s]; see `triangle_times`."""
    cycle = 4 * amplitude / speed + 2 * speed / ROUNDING
    return float(math.ceil(CYCLES * cycle + speed / ROUNDING))


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Hysteresis:
    """Actuator 1 follows the triangle under fixed feedforward."""
    machine, speed = builder.machine, QUICK_SPEED if quick else SPEED
    amplitude = np.zeros(machine.n_arms)
    amplitude[0] = machine.reference.amplitude
    seconds = duration_of(amplitude[0], speed)
    triangle: dict[str, float | Array] = {"kind": TRIANGLE, "speed": speed, "rounding": ROUNDING}
    triangle |= {"amplitude": amplitude, "passes": 1.0}
    _, fixed, _ = table_cases(machine, fit.p, seconds)
    title, duration = "slow triangle (Fig. 2)", SETTLE + seconds
    case = variant(fixed, "hysteresis", title, duration, {"reference": triangle})
    (result,) = record(builder, [case], SIGNALS, command, progress)
    return evaluate(MotionModel(machine), fit.p, result, 0, speed)


def evaluate(model: MotionModel, p: Array, result: Result, joint: int, speed: float) -> Hysteresis:
    """Branches of one joint between its two upper turns."""
    _, theta, ts = samples(result, "plant.theta", 0.0)
    tau = result["plant.tau_meas"]
    columns, measured = regression(model, Log.of("hysteresis", ts, theta, tau), SETTLE)
    angle = _aligned(model, theta, ts, len(measured))[:, joint]
    return split(angle, measured[:, joint], predicted(columns, p, joint), joint + 1, speed)


def predicted(columns: SparseRegressor, p: Array, joint: int) -> Array:
    """Torque Phi p of one joint along a log (samples,) [N m]."""
    mine = columns.rows == joint
    return np.asarray(columns.values[:, mine] @ p[columns.cols[mine]])


def _aligned(model: MotionModel, theta: Array, ts: float, count: int) -> Array:
    """Angles at the samples of `regression`: the same stride, cut and window."""
    machine = model.machine
    stride = max(1, round(machine.timing.feedforward / ts))
    first = max(int(SETTLE / (stride * ts)), 1)
    window = hann(machine.control.hann_points)
    return smooth(theta[::stride][first:-1], window)[:count]


def split(theta: Array, measured: Array, model: Array, actuator: int, speed: float) -> Hysteresis:
    """Forward and backward branch (samples,) between the two upper turns, lines removed."""
    half = len(theta) // 2
    upper = int(np.argmax(theta[:half]))
    again = half + int(np.argmax(theta[half:]))
    lower = upper + int(np.argmin(theta[upper:again]))
    loop = slice(upper, again)
    lines = [np.polyfit(theta[loop], torque[loop], 1) for torque in (measured, model)]
    rest = [
        torque - np.polyval(line, theta)
        for torque, line in zip((measured, model), lines, strict=True)
    ]

    def branch(part: slice) -> Branch:
        every = max(1, (part.stop - part.start) // POINTS)
        return Branch(*(values[part][::every] for values in (theta, *rest)))

    removed = [(float(line[1]), float(line[0])) for line in lines]
    forward, backward = branch(slice(lower, again)), branch(slice(upper, lower))
    return Hysteresis(actuator, speed, forward, backward, removed[0], removed[1])


def rows(result: Hysteresis) -> list[dict[str, Any]]:
    """What is compared: measured and model, with unit."""
    offset, stiffness = zip(result.line_measured, result.line_model, strict=True)
    width = (result.width("measured"), result.width("model"))
    return [
        {"name": "offset removed", "unit": "N m", "measured": offset[0], "model": offset[1]},
        {
            "name": "stiffness removed",
            "unit": "N m/rad",
            "measured": stiffness[0],
            "model": stiffness[1],
        },
        {"name": "width of the loop", "unit": "N m", "measured": width[0], "model": width[1]},
    ]


def figures(result: Hysteresis) -> dict[str, Figure]:
    """The loop as Fig. 2 draws it: measurement in full lines, model dashed."""
    lines = []
    for branch, name, colour in (
        (result.forward, "forward", FORWARD),
        (result.backward, "backward", BACKWARD),
    ):
        lines.append(trace(branch.theta, branch.measured, f"{name}, measured", colour))
        model = trace(branch.theta, branch.model, f"{name}, model", "#222")
        model["line"] |= {"dash": "dash", "width": 1.1}
        lines.append(model)
    title = f"Torque of actuator {result.actuator} against its angle (as Fig. 2)"
    return {
        "hysteresis": figure(title, "θ [rad]", "τ, straight line removed [N m]", lines, height=420)
    }
