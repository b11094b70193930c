"""A log of the hexapod with exact rates: all joints on sums of sines, torque Phi p with noise."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.estimation.identify import predicted
from flexhex.diagnosis.estimation.motion import MotionModel, dahl_states
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.model.parameters import base_parameters

TS, SECONDS, NOISE = 5e-4, 12.0, 0.01


def sines_log(model: MotionModel, ts: float = TS) -> Log:
    """12 s, eight sines of 0.5 to 15 rad/s for each joint, white noise of 0.01 N m."""
    rng = np.random.default_rng(3)
    t = np.arange(round(SECONDS / ts)) * ts
    n, waves = model.machine.n_arms, 8
    w = rng.uniform(0.5, 15.0, (waves, n))
    angle = w * t[:, None, None] + rng.uniform(0, 6.28, (waves, n))
    size = 0.35 / np.sqrt(waves) / (1 + w / 6)
    theta = (size * np.sin(angle)).sum(axis=1)
    thetad = (size * w * np.cos(angle)).sum(axis=1)
    thetadd = (-size * w**2 * np.sin(angle)).sum(axis=1)
    z = dahl_states(theta, model.machine.actuator.sigma)
    columns = model.columns(theta, z, thetad, thetadd)
    tau = predicted(columns, base_parameters(model.machine))
    return Log.of("made", ts, theta, tau + NOISE * rng.standard_normal(tau.shape))
