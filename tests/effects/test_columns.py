"""Columns of effects in filter and feedforward: those of raw samples, exact."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from flexhex.fmus.common.model.effect_bank import columns_function, followers
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.fmus.feedforward.equations import functions as feedforward_functions
from flexhex.fmus.filter.equations import hann
from tests.blocks.loaded import load, machine
from tests.blocks.test_filter import TS, swings
from tests.compare import assert_close
from tests.effects.machines import Array, everything
from tests.effects.test_blocks import along, known


def called(function: ca.Function, *arguments: object) -> Array:
    return np.array(function(*(ca.DM(np.asarray(a, dtype=float)) for a in arguments))).ravel()


def columns_along(theta: Array, tau: Array) -> Array:
    """Columns (ticks, n_gains) at raw samples: states advanced, rates by central differences."""
    bank = known()
    start, advance = followers(bank, "twin")
    columns = columns_function(bank, "columns")
    padded = [np.concatenate([row[:1], row]) for row in (theta, tau)]
    rows, state, last = [], called(start, theta[0]), np.zeros(31)
    for k in range(len(theta) - 1):
        (a, b, c), (u, _, w) = (row[k : k + 3] for row in padded)
        second = ((c - b) - (b - a)) / TS**2
        now = np.concatenate([b, (c - a) / (2 * TS), second, tau[k], (w - u) / (2 * TS)])
        now = np.append(now, TS * (k + 1))
        if k:
            state = called(advance, last, now, state, TS)
        rows.append(called(columns, now, state))
        last = now
    return np.array(rows)


@pytest.mark.parametrize(("alignment", "basis"), [(0, 1), (1, 1), (4, 0)])
def test_filter_windows_the_columns_of_raw_samples(alignment: int, basis: int) -> None:
    """Both forms of the filter take the columns at the raw angle; all of one instant with tau_f."""
    theta, tau = swings(320, seed=38)
    block = load("filter", everything())
    block.start(alignment=alignment, basis=basis)
    actual, tau_f = [], []
    for angle, torque in zip(theta, tau, strict=True):
        y = block.tick(theta=angle, tau_meas=torque)
        actual.append(y["chi_f"][114:])
        tau_f.append(y["tau_f"])
    raw, taps = columns_along(theta, tau), hann(101)
    windows = sliding_window_view(raw, 101, axis=0)[:, :, ::-1] @ taps
    # a window over samples k - 100 .. k appears 1 + alignment ticks after sample k
    first = 101 + alignment
    expected = windows[1 : len(actual) - first]
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-3)
    assert_close(
        np.array(actual)[first + 1 :][: len(expected)] / scale, expected / scale, atol=1e-11
    )
    torque_windows = sliding_window_view(tau, 101, axis=0)[:, :, ::-1] @ taps
    assert_close(
        np.array(tau_f)[first + 1 :],
        torque_windows[1 : len(tau_f) - first],
        atol=1e-12,
        what="tau_f, the same instants",
    )


def test_filter_first_columns_are_those_of_rest() -> None:
    block = load("filter", everything())
    y = block.start()
    declared = next(v for v in block.interface.outputs if v.name == "chi_f").starts
    assert_close(y["chi_f"], declared, atol=1e-15, what="chi_f")


def test_feedforward_advances_the_states_along_the_wanted_motion() -> None:
    torque, whole, start, advance, _ = feedforward_functions(everything())
    block = load("feedforward", everything())
    block.start()
    p = np.concatenate([base_parameters(machine()), known().values])
    bases: list[Array] = []
    state, last = np.zeros(0), np.zeros(31)
    for k, at in enumerate(along(60)):
        base = called(torque, at.x, at.xd, at.xdd, at.z, p)
        rate = (3 * base - 4 * bases[-1] + bases[-2]) / (2 * TS) if k > 1 else np.zeros(6)
        now = np.concatenate([at.x[:6], at.xd[:6], at.xdd[:6], base, rate, [TS * (k + 1)]])
        if k:
            guess = now.copy()
            guess[18:24] = called(whole, now, state, p)
            state = called(advance, last, guess, state, TS)
        else:
            state = called(start, at.x[:6])
        expected = called(whole, now, state, p)
        last = now.copy()
        last[18:24] = expected
        bases.append(base)
        actual = block.tick(x=at.x, xd=at.xd, xdd=at.xdd, z=at.z, p=p)["tau_ff"]
        # rounding of the torque over two sample times, times the lag: 1e-14 / 1e-3 * 1e-3
        assert_close(actual, expected, atol=1e-12, what=f"tau_ff, tick {k}")
    assert np.abs(state).max() > 1e-3
