"""Admission: what every effect of the library must declare and obey."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from flexhex.fmugen.blocks import block_interface
from flexhex.fmugen.units import unit
from flexhex.fmus.common.effects import Effect, Signals, library
from tests.blocks.loaded import machine
from tests.compare import assert_close
from tests.effects.machines import Array, use, values

IDS = """
    coulomb_friction stribeck_friction load_friction quadratic_drag cogging_harmonic
    torque_ripple second_hysteresis torque_offset linear_stiffness quadratic_stiffness
    cubic_stiffness cable_force torque_constant_saturation torque_saturation drive_lag
    time_delay drive_gain thermal_drift offset_drift encoder_eccentricity flexible_mode
    cross_coupling gravity_tilt joint_elasticity transmission_error
"""
KINDS = ("random", "triangle", "multisine", "chirp")
EFFECTS = list(library().values())
STATEFUL = [effect for effect in EFFECTS if effect.states]
each = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.id)
each_with_states = pytest.mark.parametrize("effect", STATEFUL, ids=lambda effect: effect.id)


def axis(values: Any) -> Signals:
    """Signals of one axis from six expressions: theta, thetad, thetadd, tau, taud, time."""
    names = ("theta", "thetad", "thetadd", "tau", "taud", "time")
    return Signals(**{name: values[k] for k, name in enumerate(names)})


def motion(t: Array) -> Array:
    """A smooth motion (samples, 6) with turns: the signals of `axis` over the time."""
    a, w, v = 0.15, 7.0, 17.0
    theta = a * np.sin(w * t) + 0.02 * np.cos(v * t)
    thetad = a * w * np.cos(w * t) - 0.02 * v * np.sin(v * t)
    thetadd = -a * w**2 * np.sin(w * t) - 0.02 * v**2 * np.cos(v * t)
    tau, taud = 3 + 2 * np.cos(5 * t), -10 * np.sin(5 * t)
    return np.stack([theta, thetad, thetadd, tau, taud, t], axis=1)


def test_library_has_the_effects_that_the_diagnosis_counts_on() -> None:
    assert set(IDS.split()) <= set(library())


@each
def test_effect_declares_units_and_bounds(effect: Effect) -> None:
    for par in (*effect.gains, *effect.shapes):
        unit(par.unit, par.name)
        assert np.isfinite([par.low, par.high]).all(), f"{par.name} has no bounds"
        assert par.low < par.high
        assert par.description
    for state in effect.states:
        unit(state.unit, state.name)
    for shape in effect.shapes:
        assert shape.grid, f"{shape.name} has nothing to try"
    units = {gain.name: gain.unit for gain in effect.gains}
    for gain in (own for own in effect.fitted if own.below):
        other, times = gain.below
        assert times > 0
        # what is of a torque or an inertia has another unit
        assert bool(gain.of) != (gain.unit == units[other])


@each
def test_effect_names_an_experiment_that_the_reference_can_run(effect: Effect) -> None:
    spec, known = (
        effect.spec,
        {v.name: v for v in block_interface("reference", machine()).variables},
    )
    assert spec.kind in KINDS
    for name, value in spec.parameters.items():
        assert known[name].min <= value <= known[name].max, name
    times = [time for time, _ in spec.payload]
    assert times == sorted(times)
    assert len(times) <= known["payload_time"].count
    assert all(0 <= mass <= known["payload_mass"].max for _, mass in spec.payload)


@each
def test_effect_has_bounded_columns(effect: Effect) -> None:
    """Finite at rest, far out, at the ends of the shapes' ranges, and one for each gain."""
    if effect.acts_on == "mechanism":
        return
    at, state = ca.SX.sym("at", 6), ca.SX.sym("state", len(effect.states))
    far = np.array([[0] * 6, [1.5, 30, 1e4, 100, 1e5, 1e5], [-1.5, -30, -1e4, -100, -1e5, 1e5]])
    for end in ("start", "low", "high"):
        shape = {s.name: getattr(s, end) for s in effect.shapes}
        signals = axis(ca.vertsplit(at))
        signals = replace(signals, others=(signals,) * 6)
        columns = ca.Function("columns", [at, state], [effect.columns(signals, state, shape)])
        for row in far:
            actual = np.array(columns(row, np.ones(len(effect.states)))).ravel()
            assert actual.shape == (len(effect.gains),)
            assert np.isfinite(actual).all()


@each
def test_what_stands_behind_a_report_is_the_same_effect_in_narrower_bounds(effect: Effect) -> None:
    behind = effect.behind or effect
    assert (behind.id, behind.behind or effect) == (effect.id, effect)
    for whole, part in ((effect.gains, behind.gains), (effect.shapes, behind.shapes)):
        assert [a.name for a in whole] == [b.name for b in part]
        assert all(a.low <= b.low < b.high <= a.high for a, b in zip(whole, part, strict=True))


@pytest.mark.parametrize(("p", "wanted"), [(40.0, 0.3 * 5.0 * 3.0), (2.0, 0.3 * 5.0 * 3.3852)])
def test_iron_saturates_at_a_corner_or_gradually(p: float, wanted: float) -> None:
    """By hand: tau (|tau| - tau_k) at a corner, else tau (sqrt(tau^2 + tau_k^2) - tau_k)."""
    effect, at = library()["torque_constant_saturation"], ca.SX.sym("at", 6)
    columns = effect.columns(axis(ca.vertsplit(at)), ca.SX(0, 1), {"tau_k": 2.0, "p": p})
    loss = ca.Function("loss", [at], [columns])
    for tau in (-5.0, 5.0):
        loss_of_torque = 0.3 * float(loss([0, 0, 0, tau, 0, 0]))
        assert loss_of_torque == pytest.approx(np.copysign(wanted, tau), rel=1e-4)


@each
def test_effect_accepts_shapes_that_are_searched(effect: Effect) -> None:
    """The diagnosis differentiates columns by their shapes: symbols must do as well as numbers."""
    if effect.acts_on == "mechanism":
        return
    at, state = ca.SX.sym("at", 6), ca.SX.sym("state", len(effect.states))
    signals = replace(axis(ca.vertsplit(at)), others=(axis(ca.vertsplit(at)),) * 6)
    shape = {s.name: ca.SX.sym(s.name) for s in effect.shapes}
    start = [s.start for s in effect.shapes]
    row, z = motion(np.array([0.3]))[0], 0.1 * np.ones(len(effect.states))
    symbols = ca.vertcat(*shape.values()) if shape else ca.SX(0, 1)
    symbolic = ca.Function("c", [at, state, symbols], [effect.columns(signals, state, shape)])
    plain = effect.columns(signals, state, {s.name: s.start for s in effect.shapes})
    numeric = ca.Function("c", [at, state], [plain])
    assert_close(symbolic(row, z, start), numeric(row, z), rtol=1e-14, what=effect.id)


@each_with_states
def test_effect_advances_as_its_rate_says(effect: Effect) -> None:
    """One second of samples at 2 kHz against Runge-Kutta steps of a tenth.

    The sampled form knows the motion at its samples alone: second order in Ts w, 2e-5 here.
    """
    shape, Ts, fine, count = {s.name: s.start for s in effect.shapes}, 5e-4, 10, 2000
    shape |= {"T": 0.5} if "T" in shape else {}
    # a reversal within a sample is a corner that a narrower angle would show
    shape |= {"s_0": 5e-3} if "s_0" in shape else {}
    # at a rate that this motion does not rush through, so that its peak is one
    shape |= {"v_s": 0.2} if "v_s" in shape else {}
    shape |= {"v_0": 0.05} if "v_0" in shape else {}
    before, middle, now = (ca.SX.sym(name, 6) for name in ("before", "middle", "now"))
    state, h = ca.SX.sym("state", len(effect.states)), Ts / fine
    then, between, there = (axis(ca.vertsplit(at)) for at in (before, middle, now))
    k1 = effect.rate(then, state, shape)
    k2 = effect.rate(between, state + h / 2 * k1, shape)
    k3 = effect.rate(between, state + h / 2 * k2, shape)
    k4 = effect.rate(there, state + h * k3, shape)
    end = state + h / 6 * (k1 + 2 * (k2 + k3) + k4)
    step = ca.Function("s", [state, before, middle, now], [end])
    advance = ca.Function(
        "a", [state, before, now], [effect.advance(then, there, state, shape, Ts)]
    )
    every = motion(np.arange(2 * fine * count + 1) * h / 2).T
    samples = every[:, :: 2 * fine]
    start = ca.DM(effect.start(axis([ca.SX(value) for value in samples[:, 0]]), shape))
    sampled = np.array(advance.mapaccum(count)(start, samples[:, :-1], samples[:, 1:]))
    path = step.mapaccum(fine * count)(start, every[:, :-2:2], every[:, 1::2], every[:, 2::2])
    exact = np.array(path)[:, fine - 1 :: fine]
    largest = np.maximum.accumulate(np.abs(exact), axis=1)
    off = (np.abs(sampled - exact) > 2e-4 * largest + 1e-6).any(axis=0)
    assert not off.any(), f"{Ts * np.argmax(off):.4f} s"
    assert (exact[:, -1] != np.array(start).ravel()).all(), "the state never moved"


def test_mode_of_a_log_that_begins_in_motion_does_not_ring() -> None:
    """What swings lags behind a constant acceleration by a / w^2, from the first sample on."""
    effect, shape = library()["flexible_mode"], {"f": 7.0, "zeta": 0.01}
    v, a, Ts = 2.0, 3.0, 1e-3
    first = axis([ca.SX(value) for value in (0, v, a, 0, 0, 0)])
    now = axis([ca.SX(value) for value in (v * Ts + a * Ts**2 / 2, v + a * Ts, a, 0, 0, Ts)])
    state = effect.start(first, shape)
    then = effect.advance(first, now, state, shape, Ts)
    lags = [float(ca.DM(z[0] - s.theta)) for z, s in ((state, first), (then, now))]
    np.testing.assert_allclose(lags, -a / (2 * np.pi * shape["f"]) ** 2, rtol=1e-9)
    assert abs(float(ca.DM(effect.columns(now, then, shape)))) < 1e-9 * a


@each_with_states
def test_effect_default_advance_agrees_with_the_exact_one(effect: Effect) -> None:
    """The base class's step of Runge-Kutta: what an effect gets that gives its rate alone."""
    shape = {s.name: s.start for s in effect.shapes}
    a, b = motion(np.array([0.2, 0.2005]))
    then, there = axis([ca.SX(v) for v in a]), axis([ca.SX(v) for v in b])
    state = ca.SX(0.1 * np.ones(len(effect.states)))
    exact = ca.DM(effect.advance(then, there, state, shape, 5e-4))
    plain = ca.DM(Effect.advance(effect, then, there, state, shape, 5e-4))
    assert_close(plain, exact, atol=1e-4 * float(np.abs(np.array(exact)).max()), what=effect.id)


def test_use_of_an_effect_keeps_its_values() -> None:
    for id, effect in library().items():
        entry, sizes = use(id), values(effect)
        assert entry.shape == {s.name: sizes.get(s.name, s.start) for s in effect.shapes}
        assert [row[0] for row in entry.gains] == [sizes[g.name] for g in effect.gains]
