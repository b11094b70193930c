"""A measured run simulated anew: plant.fmu under the logged torques, held to the logged angles.

A mechanism driven by torques alone drifts away from its log within a second. A feedback on
theta_measured - theta_simulated holds it there; the torque that it needs is the residual of the
simulation: what the model lacks, in N m.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.motion import smooth
from flexhex.diagnosis.estimation.rows import on_clock
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.runs.runs import payload_of
from flexhex.fmus.common.archive import read_bytes
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import nominal_mechanism
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import base_mechanism, base_parameters
from flexhex.fmus.feedback.design import design
from flexhex.fmus.filter.equations import hann
from flexhex.fmus.reference.equations import smooth_step
from flexhex.ssp.executor import run
from flexhex.ssp.fmu import read_fmu
from flexhex.ssp.read import Instance, Package
from flexhex.ssp.results import Result
from flexhex.ssp.wiring import Wire

Array = NDArray[np.float64]
CROSSOVER = 40.0
"""Of the feedback that holds the simulation [Hz]: it sees no noise and no delay but one sample."""
WINDOW = 0.02
"""Hann window over the residual [s]."""
SETTLE = 1.5
"""What is left out at the start of a log [s]: the hysteresis begins anew, the feedback settles."""
APPROACH = 1.0
"""Time in which the simulation goes from neutral to where a log begins [s]."""
NEUTRAL = 1e-3
"""Logs that begin nearer to neutral need no approach [rad]."""
IDEAL = {
    **{"tau_step": 0.0, "theta_step": 0.0, "command_delay": 0.0, "measurement_delay": 0.0},
    "f_current": 1e5,
}
"""Of the plant: the log has been through quanta, delays and the current loop already."""
UNLIMITED = {"tau_max": 1e4, "tau_step": 0.0, "e_max": 10.0}
"""Of the feedback."""


@dataclass(frozen=True)
class Replay:
    """Residual (samples, n) [N m], smoothed, at times (samples,) [s] of the log; judged (samples,):
    measured, settled. followed [rad]: RMS of the angle that the feedback left."""

    time: Array
    residual: Array
    judged: NDArray[np.bool_]
    followed: float

    @property
    def rms(self) -> Array:
        """RMS of the residual of each axis (n,) [N m]."""
        return np.asarray(np.sqrt((self.residual[self.judged] ** 2).mean(axis=0)))


def replay(fmus: Path, machine: Machine, p: Array, log: Log) -> Replay:
    """Run plant.fmu of a machine with parameters p along a log, with feedback.fmu beside it in the
    folder `fmus`. The first torque comes a tick after the feedback's first.

    Raises LogError when the log's channels do not meet, RunError when its angles leave the range of
    these FMUs.
    """
    base = machine.timing.base
    angle = log["theta"]
    torque, known = on_clock(log["tau_meas"], angle)
    start = angle.time[0]
    count = math.floor((angle.time[-1] - start) / base) + 1
    time = start + base * np.arange(count)
    theta = np.column_stack([np.interp(time, angle.time, column) for column in angle.values.T])
    # torque of a tick: its mean from begin to end
    tau = np.column_stack([np.interp(time + base / 2, angle.time, c) for c in torque.T])
    rise = _approach(theta[0], base)
    wanted = np.vstack([rise * theta[0], theta]) if len(rise) else theta
    given = np.vstack([np.repeat(tau[:1], len(rise), axis=0), tau])
    inputs = {
        "feedback.r": wanted,
        "feedback.tau_ff": np.vstack([given[1:], given[-1:]]),
        "plant.payload": np.full(len(wanted), payload_of(log)),
    }
    driven = _driven(fmus, {**IDEAL, **plant_values(machine, p)}, inputs, machine)
    corrections, left = driven["feedback.tau_fb"][:-1], driven["feedback.e"][1:]
    window = hann(2 * round(WINDOW / base / 2) + 1)
    half = len(window) // 2
    residual = smooth(np.pad(corrections[len(rise) :], ((half, half), (0, 0))), window)
    bad = np.interp(time, angle.time, (~(angle.valid & known)).astype(float)) > 0
    judged = (time - start > SETTLE) & (smooth(np.pad(bad.astype(float), half), window) < 1e-9)
    judged[-half:] = False
    return Replay(time, residual, judged, float(np.sqrt((left[len(rise) :][judged] ** 2).mean())))


def plant_values(machine: Machine, p: Array) -> dict[str, Array]:
    """Parameters of plant.fmu for estimated ones p: mechanism, actuators, gains of effects.

    p regroups what moves alike, and its lower arms have negative moments of inertia. What moves
    like p and is a machine is the nominal mechanism with the differences of p added.
    """
    bank, known, n = Bank.all(machine), Bank.compensated(machine), machine.n_arms
    end = len(p) - known.n_gains
    split = n * (4 + 2 * machine.actuator.n_harmonics)
    shift = p[split:end] - base_parameters(machine)[split:end]
    mechanism = nominal_mechanism(machine).vector() + base_mechanism(machine, shift).vector()
    values = {"mechanism": np.array(mechanism, dtype=float).ravel(), "actuator": p[:split]}
    if bank:
        fitted = dict(zip(known.names, p[end:], strict=True))
        pairs = zip(bank.names, bank.values, strict=True)
        values["effect"] = np.array([fitted.get(name, value) for name, value in pairs])
    return values


def _approach(theta: Array, base: float) -> Array:
    """Shares (samples, 1) of the way from neutral to theta (n,), smooth at both ends."""
    if np.abs(theta).max() < NEUTRAL:
        return np.zeros((0, 1))
    s = np.arange(round(APPROACH / base)) * base / APPROACH
    return np.asarray(smooth_step(s)[:, None])


def _driven(
    fmus: Path, values: Mapping[str, float | Array], inputs: Mapping[str, Array], machine: Machine
) -> Result:
    """The plant under given torques and the feedback on given angles, in the executor.

    inputs: at each base step; what the feedback makes of its own is at the plant one later.
    """
    control = machine.control.model_copy(update={"f_crossover": CROSSOVER})
    drive = machine.drive.model_copy(update={"t_command": 0.0, "t_measurement": 0.0})
    gains = design(machine.model_copy(update={"control": control, "drive": drive}))
    feedback = {**asdict(gains), "reference_delay": 0.0, **UNLIMITED}
    parameters = {
        **{f"feedback.{name}": value for name, value in feedback.items()},
        **{f"plant.{name}": value for name, value in values.items()},
    }
    count = len(inputs["feedback.r"])
    return run(
        _system(fmus, machine),
        count * machine.timing.base,
        signals=("feedback.tau_fb", "feedback.e"),
        parameters=parameters,
        inputs=inputs,
        timing=False,
    )


def _system(fmus: Path, machine: Machine) -> Package:
    """Feedback and plant, in memory."""
    files = {name: fmus / f"{name}.fmu" for name in ("feedback", "plant")}
    data = {name: read_bytes(path) for name, path in files.items()}
    instances = tuple(
        Instance(name, name, read_fmu(data[name], str(path)), {}) for name, path in files.items()
    )
    ends = (("feedback", "tau", "plant", "tau"), ("plant", "theta", "feedback", "theta"))
    wires = tuple(
        Wire(source, f"{output}[{i}]", target, f"{taken}[{i}]")
        for source, output, target, taken in ends
        for i in range(1, machine.n_arms + 1)
    )
    return Package(fmus, "replay", machine.timing.base, instances, wires, data)
