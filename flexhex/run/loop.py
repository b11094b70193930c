"""The open feedback loop of one joint, PID times plant: Bode plot and stability margins.

L(z) = C(z) P(z), both from `flexhex.fmus.feedback.design`: zero-order hold, current loop, the
delays of computation and drive, and the inertia J_design that the gains are designed for.
tests/flexhex/test_loop_margins.py checks the margins with python-control.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.feedback.design import design, plant_response
from flexhex.output.plots import Figure, figure, trace
from flexhex.output.tables import Column

Array = NDArray[np.float64]
LOWEST, POINTS = 0.2, 4000
"""Lowest frequency of the plot [Hz], points up to half the sampling rate."""
COLUMNS = (
    Column("crossover", "crossover", "Hz", ".2f"),
    Column("phase_margin", "phase margin", "°", ".1f"),
    Column("gain_up", "gain may rise by", "dB", ".1f"),
    Column("gain_down", "gain may fall by", "dB", ".1f"),
    Column("delay_margin", "delay margin", "ms", ".2f"),
)
LOG = {"type": "log", "dtick": 1}


@dataclass(frozen=True)
class Margins:
    """crossover [Hz], phase_margin [deg], delay_margin [ms]: further delay that the loop bears.
    gain_up, gain_down [dB]: change of gain that the loop bears; infinite without a limit."""

    crossover: float
    phase_margin: float
    gain_up: float
    gain_down: float
    delay_margin: float


def open_loop(machine: Machine, f: Array) -> NDArray[np.complex128]:
    """L at the frequencies f [Hz], (n,)."""
    Ts, gains = machine.timing.base, design(machine)
    z = [complex(v) for v in np.exp(2j * np.pi * np.asarray(f) * Ts)]
    return np.array([gains.response(v, Ts) * plant_response(machine, v) for v in z])


def grid(machine: Machine) -> Array:
    """Frequencies of the plot [Hz], below half the sampling rate."""
    return np.geomspace(LOWEST, 0.499 / machine.timing.base, POINTS)


def margins(machine: Machine) -> Margins:
    """Margins of the open loop, at the crossings of gain 1 and of phase -180 degrees."""
    from scipy.optimize import brentq

    f = grid(machine)

    def gain(x: float) -> float:
        return math.log(abs(open_loop(machine, np.array([x]))[0]))

    def imaginary(x: float) -> float:
        return float(open_loop(machine, np.array([x]))[0].imag)

    L = open_loop(machine, f)
    crossings = _between(f, np.log(np.abs(L)))
    crossover = max(float(brentq(gain, *pair)) for pair in crossings)
    phase = np.angle(-open_loop(machine, np.array([crossover]))[0])
    turns = [float(brentq(imaginary, *pair)) for pair in _between(f, L.imag)]
    at_turns = open_loop(machine, np.array(turns))
    decibels = [-20 * math.log10(abs(value)) for value in at_turns if value.real < 0]
    return Margins(
        crossover,
        math.degrees(phase),
        min((d for d in decibels if d > 0), default=math.inf),
        min((-d for d in decibels if d < 0), default=math.inf),
        1e3 * float(phase) / (2 * math.pi * crossover),
    )


def _between(f: Array, values: Array) -> list[tuple[float, float]]:
    """Neighbours of the grid between which the values change their sign."""
    at = np.flatnonzero(np.diff(np.sign(values)))
    return [(float(f[k]), float(f[k + 1])) for k in at]


def bode(machine: Machine) -> Figure:
    """Magnitude and phase of the open loop over frequency."""
    f = grid(machine)
    L = open_loop(machine, f)
    phase = np.degrees(np.unwrap(np.angle(L)))
    phase -= 360 * np.ceil(phase[0] / 360)
    lines = [
        trace(f, 20 * np.log10(np.abs(L)), "magnitude", "#1f6fb2"),
        trace(f, phase, "phase", "#d1731d", yaxis="y2"),
    ]
    lower = {"domain": [0, 0.45], "title": {"text": "phase [°]"}}
    return figure(
        "Open feedback loop of one joint, PID and plant with all delays",
        "frequency [Hz]",
        "magnitude [dB]",
        lines,
        xaxis=LOG | {"anchor": "y2"},
        yaxis={"domain": [0.55, 1]},
        yaxis2=lower | {"zeroline": False, "dtick": 90},
        height=420,
    )
