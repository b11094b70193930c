"""A measured run simulated anew: plant.fmu under the logged torques, held to the logged angles.

A mechanism driven by torques alone drifts away from its log within a second. A feedback on
theta_measured - theta_simulated holds it there; the torque that it needs is the residual of the
simulation: what the model lacks, in N m.
"""

from __future__ import annotations

import ctypes
import math
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.motion import smooth
from flexhex.diagnosis.estimation.rows import on_clock
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.runs.runs import payload_of
from flexhex.fmus.common.interface import array_of
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import nominal_mechanism
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import base_mechanism, base_parameters
from flexhex.fmus.feedback import equations as feedback
from flexhex.fmus.feedback.design import Gains, design
from flexhex.fmus.filter.equations import hann
from flexhex.fmus.reference.equations import smooth_step

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
IDEAL = {"tau_step": 0.0, "theta_step": 0.0, "command_delay": 0.0, "measurement_delay": 0.0}
"""The log has been through quanta and delays already."""


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


def replay(plant: Path, machine: Machine, p: Array, log: Log) -> Replay:
    """Run plant.fmu of a machine with parameters p along a log.

    Raises LogError when the log's channels do not meet.
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
    values = {**IDEAL, "f_current": 1e5, **plant_values(machine, p)}
    with_feedback = _Follower(machine)
    corrections, left = with_feedback.run(plant, values, wanted, given, payload_of(log))
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


class _Follower:
    """PID of all axes, [SH, IV-C] with another crossover, Tustin's rule."""

    def __init__(self, machine: Machine) -> None:
        control = machine.control.model_copy(update={"f_crossover": CROSSOVER})
        drive = machine.drive.model_copy(update={"t_command": 0.0, "t_measurement": 0.0})
        self.gains: Gains = design(machine.model_copy(update={"control": control, "drive": drive}))
        self.Ts, self.n = machine.timing.base, machine.n_arms

    def run(
        self,
        plant: Path,
        values: Mapping[str, Any],
        wanted: Array,
        given: Array,
        payload: float,
    ) -> tuple[Array, Array]:
        """Torque of the feedback and remaining angle (samples, n)."""
        g, Ts = self.gains, self.Ts
        corrections, left = np.zeros_like(wanted), np.zeros_like(wanted)
        e_I = e_D = np.zeros(self.n)
        last = wanted[0].copy()
        with _Plant(plant, values, payload) as machine:
            theta = machine.theta
            for k in range(len(wanted)):
                e = wanted[k] - theta
                e_I = feedback.integrated(e_I, last, e, Ts)
                e_D = feedback.differentiated(e_D, last, e, g.t_f, Ts)
                corrections[k] = feedback.torque(e, e_I, e_D, g.kp, g.t_i, g.t_d)
                left[k], last = e, e
                machine.step(given[k] + corrections[k], k * Ts, Ts)
        return corrections, left


LOADING = Lock()
"""fmpy changes the working directory of the whole process while it loads a library: a relative path
of another replay would lead nowhere, and the directory might stay changed."""


def _loaded(fmu: Path) -> tuple[Any, str, Any]:
    """Description, folder with the files, instance of an FMU, one at a time."""
    with LOADING:
        # our own FMU; fmpy's schema is not safe where replays run side by side
        description = fmpy.read_model_description(str(fmu), validate=False)
        folder = fmpy.extract(str(fmu))
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="replay",
        )
    return description, folder, slave


class _Plant:
    """One instance of plant.fmu; theta (n,) is what it showed last."""

    def __init__(self, fmu: Path, values: Mapping[str, Any], payload: float) -> None:
        description, self.folder, self.slave = _loaded(fmu)
        references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave.instantiate()
        parameters = [v for v in description.modelVariables if v.causality == "parameter"]
        for name, value in values.items():
            scalars = [v for v in parameters if array_of(v.name) == name]
            for v, number in zip(scalars, np.atleast_1d(value).tolist(), strict=True):
                if v.type == "Integer":
                    self.slave.setInteger([v.valueReference], [round(number)])
                else:
                    self.slave.setReal([v.valueReference], [number])
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        n = sum(v.name.startswith("theta[") for v in description.modelVariables)
        self._inputs = (ctypes.c_uint * n)(*(references[f"tau[{i + 1}]"] for i in range(n)))
        self._outputs = (ctypes.c_uint * n)(*(references[f"theta[{i + 1}]"] for i in range(n)))
        self.theta, self._tau = np.zeros(n), np.zeros(n)
        real = ctypes.POINTER(ctypes.c_double)
        self._theta_at = self.theta.ctypes.data_as(real)
        self._tau_at = self._tau.ctypes.data_as(real)
        self.slave.setReal([references["payload"]], [payload])

    def __enter__(self) -> _Plant:
        return self

    def __exit__(self, *_: object) -> None:
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def step(self, tau: Array, time: float, Ts: float) -> None:
        """One tick under a torque command (n,) [N m]."""
        s, n = self.slave, len(self._tau)
        self._tau[:] = tau
        s.fmi2SetReal(s.component, self._inputs, n, self._tau_at)
        s.doStep(time, Ts)
        s.fmi2GetReal(s.component, self._outputs, n, self._theta_at)
