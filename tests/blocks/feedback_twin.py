"""The feedback C in plain NumPy, from [SH, IV-C] and its README: another realisation of the PID.

The derivative is the slope left by a low-pass filter, the integral is summed apart, the delayed
reference is a polynomial through the samples around it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Twin:
    """Six controllers; units as in the interface."""

    Ts: float
    kp: float
    t_i: float
    t_d: float
    t_f: float
    delay: float
    tau_max: float
    tau_step: float
    ff_gain: float = 1.0
    e_max: float = 0.2
    past: list[Array] = field(default_factory=list)
    summed: Array = field(default_factory=lambda: np.zeros(6))
    low: Array = field(default_factory=lambda: np.zeros(6))
    last: Array | None = None
    rest: Array = field(default_factory=lambda: np.zeros(6))

    def delayed(self, r: Array) -> Array:
        """r `delay` samples ago: the cubic through two samples on either side where they exist."""
        self.past.append(r.copy())
        first = max(int(self.delay) - 1, 0)
        ages = np.arange(first, first + 4)
        samples = np.array([self.past[max(len(self.past) - 1 - age, 0)] for age in ages])
        powers = np.vander(ages - self.delay, 4)
        return np.asarray(np.linalg.solve(powers, samples)[-1])

    def slope(self, e: Array) -> Array:
        """Derivative of e behind the lag t_f: what the low-pass filter is behind, over t_f."""
        assert self.last is not None
        a = self.Ts / (2 * self.t_f)
        self.low = ((1 - a) * self.low + a * (e + self.last)) / (1 + a)
        return (e - self.low) / self.t_f

    def tick(self, r: Array, theta: Array, tau_ff: Array) -> dict[str, Array | float]:
        """tau, tau_fb [N m], e [rad], fault."""
        e = self.delayed(r) - theta
        if self.last is None:
            self.low, self.last = e, e
            self.summed = -self.t_i * e
            grown = self.summed
            slope = np.zeros(6)
        else:
            grown = self.summed + self.Ts * (self.last + e) / 2
            slope = self.slope(e)
            self.last = e

        def torque(summed: Array) -> Array:
            return self.kp * e + self.kp / self.t_i * summed + self.kp * self.t_d * slope

        wanted = torque(grown) + self.ff_gain * tau_ff
        beyond = np.abs(wanted) > self.tau_max
        outward = np.sign(grown - self.summed) == np.sign(wanted)
        self.summed = np.where(beyond & outward, self.summed, grown)
        tau_fb = torque(self.summed)
        # with current steps the limit is the largest whole step below it
        most = self.tau_max
        if self.tau_step > 0:
            most = self.tau_step * np.floor(self.tau_max / self.tau_step + 1e-9)
        tau = np.clip(tau_fb + self.ff_gain * tau_ff, -most, most)
        if self.tau_step > 0:
            owed = tau + self.rest
            tau = np.clip(self.tau_step * np.rint(owed / self.tau_step), -most, most)
            self.rest = owed - tau
        fault = 3.0 if np.any(np.abs(e) > self.e_max) else 2.0 if beyond.any() else 0.0
        return {"tau": tau, "tau_fb": tau_fb, "e": e, "fault": fault}
