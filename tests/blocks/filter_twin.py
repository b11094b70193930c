"""The measurement filter W over a whole record, in plain NumPy from [SH, IV-D]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Twin:
    """W for n joints; Ts [s], sigma [rad], omega [1/rad].

    raw_basis: window over the basis of the raw angle; otherwise the paper's form, the basis
    of the filtered angle.
    """

    Ts: float
    sigma: float
    omega: float
    points: int = 101
    harmonics: int = 9
    alignment: int = 1
    raw_basis: bool = True

    def run(self, theta: Array, tau: Array) -> dict[str, Array]:
        """Outputs of every tick for theta [rad], tau [N m] (ticks, n): arrays (ticks, ...).

        Before the record everything has always been as in its first sample, with z = 0.
        """
        before = self.points + 2 + self.alignment
        past = self._padded(theta, before)
        smooth = self._window(past)
        if self.raw_basis:
            chi = self._padded(self.basis(theta), before)
            chi_f = self._window(chi)[:-1]
        else:
            chi_f = self.basis(smooth)[:-1]
        now, newer, older = smooth[1:-1], smooth[2:], smooth[:-2]
        late = slice(-len(theta) - self.alignment, -self.alignment or None)
        return {
            "theta_f": now[-len(theta) :],
            "theta_fd": ((newer - older) / (2 * self.Ts))[-len(theta) :],
            "theta_fdd": ((newer - 2 * now + older) / self.Ts**2)[-len(theta) :],
            "tau_f": self._window(self._padded(tau, before))[:-1][late],
            "chi_f": chi_f[late],
        }

    def basis(self, theta: Array) -> Array:
        """(ticks, n (1 + 2 harmonics)): joint by joint z, cos 1, sin 1, cos 2, ..."""
        orders = self.omega * np.arange(1, self.harmonics + 1)
        phase = theta[:, :, None] * orders
        waves = np.stack([np.cos(phase), np.sin(phase)], axis=-1).reshape(*theta.shape, -1)
        z = self.dahl(theta)[:, :, None]
        return np.concatenate([z, waves], axis=-1).reshape(len(theta), -1)

    def dahl(self, theta: Array) -> Array:
        """Dahl states (ticks, n) from z = 0 at the first angle, exact over monotone steps."""
        z = np.zeros_like(theta)
        for k in range(1, len(theta)):
            step = theta[k] - theta[k - 1]
            s = np.sign(step)
            z[k] = s + (z[k - 1] - s) * np.exp(-np.abs(step) / self.sigma)
        return z

    def _window(self, signal: Array) -> Array:
        """Hann window of unit gain [SH, Eq. (27)]; rows where it is full."""
        taps = np.sin(np.pi * np.arange(self.points) / self.points) ** 2
        taps = taps / taps.sum()
        columns = [np.convolve(column, taps, mode="valid") for column in signal.T]
        return np.stack(columns, axis=1)

    @staticmethod
    def _padded(signal: Array, count: int) -> Array:
        return np.concatenate([np.repeat(signal[:1], count, axis=0), signal])
