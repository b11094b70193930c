"""PID of one joint for a wanted crossover and phase margin, in closed form and plain NumPy.

The loop that is designed is the sampled one, with everything that delays it:

    C(z) z^-(1 + delays of the drive) P(z)

P(z): zero-order hold, current loop a / (s + a), inertia 1 / (J s^2); the one step is the
feedback's own computation: what a tick computes is seen from the next one on.
tests/blocks/test_feedback.py checks the result with python-control.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.machine import Machine

LARGEST_LEAD = math.radians(80)
"""Beyond this the lead filter amplifies noise 130-fold and more: no sensible design."""


@dataclass(frozen=True)
class Gains:
    """tau_fb = kp (1 + 1 / (t_i s) + t_d s / (t_f s + 1)) e, made discrete by Tustin's rule.

    kp [N m/rad], t_i, t_d, t_f [s].
    """

    kp: float
    t_i: float
    t_d: float
    t_f: float

    def response(self, z: complex, Ts: float) -> complex:
        """C(z) [N m/rad]."""
        s = 2 / Ts * (z - 1) / (z + 1)
        return self.kp * (1 + 1 / (self.t_i * s) + self.t_d * s / (self.t_f * s + 1))


def delay_steps(machine: Machine) -> int:
    """Base steps from the sample of the angle to the torque command in the drive."""
    drive, Ts = machine.drive, machine.timing.base
    return 1 + round(drive.t_command / Ts) + round(drive.t_measurement / Ts)


def plant_response(machine: Machine, z: complex) -> complex:
    """P(z) with the delays of the loop [rad/(N m)], for the inertia J_design.

    From the step response of a / (J s^2 (s + a)): t^2 / 2 - t / a + (1 - exp(-a t)) / a^2.
    """
    Ts, a = machine.timing.base, 2 * math.pi * machine.drive.f_current
    left, w = math.exp(-a * Ts), z - 1
    samples = Ts**2 * (z + 1) / (2 * w**2) - Ts / (a * w) + (1 - w / (z - left)) / a**2
    return samples / (machine.control.J_design * z ** delay_steps(machine))


def design(machine: Machine) -> Gains:
    """Gains with exactly `f_crossover` and `phase_margin` on the inertia `J_design`.

    C is K (1 + w_i / s) (1 + s / w_z) / (1 + s / w_p): a PI corner at crossover /
    integrator_ratio, a lead filter about the crossover whose ratio w_p / w_z gives the
    phase that is missing. Tustin's rule turns the frequency f into tan(pi f Ts) / (pi Ts),
    so corners are set on that scale and the margin is exact.

    Raises MachineError when no lead filter gives that margin.
    """
    control, Ts = machine.control, machine.timing.base
    if 2 * control.f_crossover * Ts >= 1:
        raise MachineError(
            f"control.f_crossover = {control.f_crossover:.6g} Hz, must be below half the"
            f" feedback's rate of {1 / Ts:.6g} Hz"
        )
    z = cmath.exp(2j * math.pi * control.f_crossover * Ts)
    w = 2 / Ts * math.tan(math.pi * control.f_crossover * Ts)
    lag = -cmath.phase(-plant_response(machine, z)) + math.atan(1 / control.integrator_ratio)
    lead = control.phase_margin + lag
    if not 0 < lead <= LARGEST_LEAD:
        raise MachineError(
            f"control.phase_margin = {control.phase_margin:.4g} rad at"
            f" {control.f_crossover:.4g} Hz needs a lead of {lead:.3g} rad, possible are 0 to"
            f" {LARGEST_LEAD:.3g}: change the margin, lower f_crossover or raise integrator_ratio"
        )
    root = math.tan(math.pi / 4 + lead / 2)
    shape = _parallel(w / control.integrator_ratio, w / root, w * root)
    gain = abs(shape.response(z, Ts) * plant_response(machine, z))
    return Gains(shape.kp / gain, shape.t_i, shape.t_d, shape.t_f)


def _parallel(w_i: float, w_z: float, w_p: float) -> Gains:
    """(1 + w_i / s) (1 + s / w_z) / (1 + s / w_p) by partial fractions; corners [rad/s]."""
    kp = 1 + w_i / w_z - w_i / w_p
    return Gains(kp, kp / w_i, (1 / w_z - kp / w_p) / kp, 1 / w_p)
