"""Margins of the feedback loop in the report: python-control's, and those that the paper states."""

from __future__ import annotations

import control
import numpy as np
import pytest

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.feedback.design import delay_steps, design
from flexhex.run.loop import bode, margins


def loop(m: Machine) -> control.StateSpace:
    """PID (Tustin), zero-order hold, current loop, inertia and delay, sampled by python-control."""
    a, Ts, gains = 2 * np.pi * m.drive.f_current, m.timing.base, design(m)
    A = np.array([[0, 1, 0], [0, 0, 1 / m.control.J_design], [0, 0, -a]])
    drive = control.ss(A, np.array([[0], [0], [a]]), np.array([[1, 0, 0]]), 0)
    plant = control.sample_system(drive, Ts, method="zoh")
    s = control.tf("s")
    pid = gains.kp * (1 + 1 / (gains.t_i * s) + gains.t_d * s / (gains.t_f * s + 1))
    delay = control.ss(control.tf([1], [1, *[0] * delay_steps(m)], Ts))
    return control.series(delay, plant, control.ss(control.sample_system(pid, Ts, method="tustin")))


def test_margins_are_those_of_python_control(machine: Machine) -> None:
    """1e-4: its crossings are interpolated between frequencies of its own choice."""
    own = margins(machine)
    gains, phases, _, turns, crossings, _ = control.stability_margins(loop(machine), returnall=True)
    at = np.argmin(abs(crossings / (2 * np.pi) - own.crossover))
    assert own.crossover == pytest.approx(crossings[at] / (2 * np.pi), rel=1e-4)
    assert own.phase_margin == pytest.approx(phases[at], rel=1e-4)
    decibels = 20 * np.log10(gains[turns > 0])
    assert own.gain_up == pytest.approx(min(d for d in decibels if d > 0), rel=1e-4)
    assert own.gain_down == pytest.approx(min(-d for d in decibels if d < 0), rel=1e-4)


def test_design_has_the_papers_crossover_and_phase_margin(machine: Machine) -> None:
    """10 Hz and 45 degrees, [SH, IV]; the delay that takes 45 degrees at 10 Hz is 12.5 ms."""
    own = margins(machine)
    assert own.crossover == pytest.approx(10.0, rel=1e-9)
    assert own.phase_margin == pytest.approx(45.0, rel=1e-9)
    assert own.delay_margin == pytest.approx(12.5, rel=1e-9)


def test_bode_plot_crosses_where_the_margins_say(machine: Machine) -> None:
    magnitude, phase = bode(machine)["data"]
    f = np.array(magnitude["x"])
    assert np.interp(10.0, f, magnitude["y"]) == pytest.approx(0.0, abs=0.05)
    assert np.interp(10.0, np.array(phase["x"]), phase["y"]) == pytest.approx(-135.0, abs=0.5)
