"""The design of C: crossover, margin, stability, and the block that answers as designed."""

from __future__ import annotations

import cmath

import control
import numpy as np
import pytest

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.feedback.design import design
from tests.blocks.feedback_design import TS, altered, discrete_controller, discrete_plant, gains
from tests.blocks.loaded import machine
from tests.blocks.test_feedback import PLAIN, started

LATE = {"t_command": 0.0005, "t_measurement": 0.00025}


@pytest.mark.parametrize(
    ("section", "values"),
    [
        ("control", {}),
        ("control", {"f_crossover": 25.0, "phase_margin": 0.6}),
        ("control", {"integrator_ratio": 4.0, "J_design": 0.01}),
        ("drive", {"f_current": 200.0}),
        ("drive", LATE),
    ],
)
def test_design_has_the_crossover_and_the_margin(section: str, values: dict[str, float]) -> None:
    """python-control finds both in the sampled loop with all its delays; 10 Hz and 45 deg."""
    m = altered(section, **values)
    loop = control.series(discrete_controller(m, design(m)), discrete_plant(m, m.control.J_design))
    w = 2 * np.pi * m.control.f_crossover
    # |L| = 1 and the angle at the crossover: rounding of a loop with three poles at z = 1
    z = cmath.exp(1j * w * m.timing.base)
    value = complex(np.squeeze(loop(z)))
    assert abs(value) == pytest.approx(1, abs=1e-6)
    assert np.pi + cmath.phase(value) == pytest.approx(m.control.phase_margin, abs=1e-6)
    # and there is no other crossover, as a search over all frequencies finds
    grid = np.geomspace(0.02, 0.49 / m.timing.base, 4000)
    values_on_grid = loop(np.exp(2j * np.pi * grid * m.timing.base))
    response = control.FRD(values_on_grid, 2 * np.pi * grid, smooth=True)
    _, margin, _, _, crossover, _ = control.stability_margins(response)
    assert crossover / (2 * np.pi) == pytest.approx(m.control.f_crossover, abs=0.01)
    assert margin == pytest.approx(np.degrees(m.control.phase_margin), abs=0.05)


@pytest.mark.parametrize("share", [0.5, 0.75, 1.0, 1.5, 2.0])
def test_design_is_stable_for_half_and_twice_the_inertia(share: float) -> None:
    m = machine()
    loop = control.series(
        discrete_controller(m, gains()), discrete_plant(m, share * m.control.J_design)
    )
    closed = control.feedback(loop, 1)
    assert np.abs(closed.poles()).max() < 1 - 1e-4
    # and with a distance from -1 in every direction: |1 / (1 + L)| <= 2.2
    points = np.exp(2j * np.pi * np.geomspace(0.1, 1900, 400) * TS)
    assert max(abs(1 / (1 + complex(np.squeeze(loop(z))))) for z in points) < 2.2


@pytest.mark.parametrize("f", [1.0, 10.0, 125.0])
def test_feedback_answers_as_designed(f: float) -> None:
    """The block's torque to a sine of theta, fitted over whole periods: -C(z)."""
    period = round(1 / (f * TS))
    block, settle, ticks = started(**PLAIN), 400, 4 * period
    t = TS * np.arange(settle + ticks)
    theta = 1e-3 * np.sin(2 * np.pi * f * t)
    tau = np.array([block.tick(theta=np.full(6, angle))["tau_fb"][0] for angle in theta])[settle:]
    # a constant is what the integral began with; of the derivative's start exp(-0.1 / t_f) is left
    basis = np.exp(2j * np.pi * f * t[settle:])
    columns = np.column_stack([basis.imag, basis.real, np.ones(ticks)])
    real, imaginary, _ = np.linalg.lstsq(columns, tau, rcond=None)[0]
    actual = complex(real, imaginary) / -1e-3
    expected = gains().response(cmath.exp(2j * np.pi * f * TS), TS)
    assert abs(actual - expected) < 1e-6 * abs(expected)


def test_design_refuses_what_no_lead_filter_can() -> None:
    with pytest.raises(MachineError, match=r"^control.phase_margin = 1.4 rad at 10 Hz needs a"):
        design(altered("control", phase_margin=1.4))
    with pytest.raises(MachineError, match=r"^control.f_crossover = 2000 Hz, must be below half"):
        design(altered("control", f_crossover=2000.0))
