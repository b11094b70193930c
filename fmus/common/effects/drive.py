"""What lies between the torque that a drive reports and the torque at the joint."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain, Shapes, Signals

FAST = Experiment("chirp", {"f0": 0.2, "f1": 8.0, "amplitude": 0.02})


class DriveLag(Effect):
    """T_lag taud, the first order of a lag T_lag tau_joint' = tau - tau_joint."""

    id, title, acts_on, line = "drive_lag", "lag of the drive", "drive", "lag"
    gains = (Gain("T_lag", "s", 2e-4, 0.0, 0.01, "time constant"),)
    reported = True
    excites = "torques that change fast"
    confused_with = ("time_delay", "flexible_mode")
    experiment = "chirp: a lag loses amplitude at high frequency, a delay does not"
    spec = FAST

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.taud


class TimeDelay(Effect):
    """T_delay taud, the first order of tau_joint(t) = tau(t - T_delay)."""

    id, title, acts_on, line = "time_delay", "delay of the drive", "drive", "delay"
    gains = (Gain("T_delay", "s", 2e-4, 0.0, 0.01, "delay"),)
    reported = True
    excites = "torques that change fast"
    confused_with = ("drive_lag", "flexible_mode")
    experiment = "chirp: a lag loses amplitude at high frequency, a delay does not"
    spec = FAST

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.taud


class DriveGain(Effect):
    """g tau: the motor constant is g smaller than the drive believes."""

    id, title, acts_on = "drive_gain", "error of the motor constant", "drive"
    loses = True
    gains = (Gain("g", "1", 0.01, -0.5, 0.5, "relative loss"),)
    reported = True
    excites = "a change of payload of known mass"
    confused_with = ("thermal_drift", "torque_constant_saturation", "torque_ripple")
    experiment = "random setpoints without and with a known payload"
    spec = Experiment("random", {}, ((0.0, 0.0), (25.0, 1.0)))

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        return s.tau

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        return f"the drive reports {1 / (1 - values['g']):.3f} times what the joint gets"


EFFECTS = (DriveLag(), TimeDelay(), DriveGain())
