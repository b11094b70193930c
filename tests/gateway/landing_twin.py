"""What a landing of the gateway follows, anew: its path, and the torques of the model by FMPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.gateway.bench import Rows
from tests.gateway.slave import Slave
from tests.gateway.weight import TS

SPEED, BRAKE, PAUSE, MOST = 0.25, 0.1, 0.3, 6.0
"""[landing] of the template: rad/s, s, s, N m."""
PERIOD = 2 * TS
"""Of kinematics.fmu and feedforward.fmu [s]."""


def smooth(s: float) -> float:
    """The fifth-order polynomial with rate and acceleration 0 at both ends."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


class Braked:
    """From a pose at a rate to rest, then to the rest pose."""

    def __init__(self, start: Rows, rate: Rows, rest: Rows) -> None:
        self.start, self.rate, self.rest = start, rate, rest
        self.brake, self.pause = round(BRAKE / TS), round(PAUSE / TS)
        self.stop = start + rate * (self.brake * TS) / 2.0
        travel = int(np.ceil(1.875 * np.abs(rest - self.stop).max() / SPEED / TS))
        self.travel = max(travel, self.brake) if travel else 0
        self.cycles = self.brake + self.pause + self.travel + self.pause

    def at(self, k: int) -> Rows:
        """Angles of cycle k."""
        if k < self.brake:
            s = k / self.brake
            share = s - s * s * s + s * s * s * s / 2.0
            return self.start + self.rate * (self.brake * TS) * share
        moved = max(k - self.brake - self.pause, 0)
        if moved >= self.travel:
            return self.rest
        return self.stop + (self.rest - self.stop) * smooth(moved / self.travel)

    def motion(self, k: int) -> tuple[Rows, Rows, Rows]:
        """Angles, rates and accelerations of the cycle after k."""
        before, now, after = (self.at(k + j) for j in range(3))
        rates = (after - before) / (2.0 * TS)
        return now, rates, (after - 2.0 * now + before) / (TS * TS)


class Model:
    """The torques that a motion takes: kinematics.fmu and feedforward.fmu, two ticks for each."""

    def __init__(self, fmu_dir: Path, folder: Path) -> None:
        self.kinematics = Slave(fmu_dir / "kinematics.fmu", folder / "kinematics", "N_F")
        self.feedforward = Slave(fmu_dir / "feedforward.fmu", folder / "feedforward", "F")
        names = self.kinematics.references.keys() & self.feedforward.references.keys()
        self.between = sorted(n for n in names if n.startswith(("x.", "xd.", "xdd.", "z[")))
        self.ticks, self.tau = {self.kinematics: 0, self.feedforward: 0}, np.zeros(6)

    def torque(self, theta: Rows, thetad: Rows, thetadd: Rows) -> Rows:
        """Torques (6,) [N m]."""
        for name, values in (("theta", theta), ("thetad", thetad), ("thetadd", thetadd)):
            self.kinematics.set({f"{name}[{k}]": v for k, v in enumerate(values, start=1)})
        self._tick(self.kinematics)
        values = self.kinematics.get(self.between)
        self.feedforward.set(dict(zip(self.between, values, strict=True)))
        self._tick(self.feedforward)
        self.tau = np.array(self.feedforward.get([f"tau_ff[{k}]" for k in range(1, 7)]))
        self._tick(self.kinematics)
        return self.tau

    def _tick(self, fmu: Slave) -> None:
        fmu.fmu.doStep(self.ticks[fmu] * PERIOD, PERIOD)
        self.ticks[fmu] += 1
