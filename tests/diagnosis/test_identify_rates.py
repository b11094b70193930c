"""The fit takes logs of any rate from 60 Hz on: the same parameters, with honest deviations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identify import Fit, fit
from flexhex.diagnosis.estimation.motion import MotionModel, motion_model
from flexhex.diagnosis.estimation.rows import parts, rates, window_of
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters
from tests.diagnosis.sines import TS, sines_log


@pytest.fixture(scope="module")
def model(machine: Machine) -> MotionModel:
    return motion_model(machine)


@pytest.fixture(scope="module")
def fast(model: MotionModel) -> Log:
    """4 kHz."""
    return sines_log(model, TS / 2)


@pytest.fixture(scope="module")
def of_2_kHz(machine: Machine, fast: Log) -> Fit:
    return fit(machine, [thinned(fast, 2)])


def thinned(log: Log, every: int, *names: str) -> Log:
    """Every n-th sample of these channels, of all where none is named."""
    channels = {
        name: replace(c, ts=c.ts * every, values=c.values[::every], valid=c.valid[::every])
        if name in names or not names
        else c
        for name, c in log.channels.items()
    }
    return replace(log, channels=channels)


def test_log_faster_than_the_feedforward_is_thinned_to_its_rate(
    machine: Machine, fast: Log, of_2_kHz: Fit
) -> None:
    fitted = fit(machine, [fast])
    assert np.array_equal(fitted.p, of_2_kHz.p)
    assert np.array_equal(fitted.std, of_2_kHz.std)


@pytest.mark.parametrize("every", [4, 8, 16, 64], ids=["1kHz", "500Hz", "250Hz", "62.5Hz"])
def test_slower_log_gives_the_same_parameters(
    every: int, machine: Machine, fast: Log, of_2_kHz: Fit
) -> None:
    """162 normal values: 4.5 deviations have a chance of a thousandth. Samples of the 2 kHz log are
    among them, so the difference of both fits is no larger than the slower one's deviation."""
    fitted = fit(machine, [thinned(fast, every)])
    off = (fitted.p - base_parameters(machine)) / fitted.std
    assert np.abs(off).max() < 4.5
    assert 0.5 < np.sqrt((off**2).mean()) < 1.5
    assert np.abs((fitted.p - of_2_kHz.p) / fitted.std).max() < 4.5
    # white noise: the deviation grows with the root of the number of samples that are not there
    growth = np.median(fitted.std / of_2_kHz.std)
    assert growth == pytest.approx(np.sqrt(every / 2), rel=0.25)


def test_slower_torque_sets_the_rows(machine: Machine, fast: Log) -> None:
    """Angles at 4 kHz and torques at 250 Hz fit as both at 250 Hz do: cubic interpolation at its
    nodes is exact, whatever the angle did between them."""
    both = fit(machine, [thinned(fast, 16)])
    fitted = fit(machine, [thinned(fast, 16, "tau_meas")])
    assert np.abs((fitted.p - both.p) / both.std).max() < 1e-6


def test_window_is_equally_long_at_every_rate(machine: Machine) -> None:
    length = machine.control.hann_points * machine.timing.feedforward
    assert len(window_of(machine, machine.timing.feedforward)) == machine.control.hann_points
    for ts in (0.001, 0.002, 0.004, 0.016):
        assert len(window_of(machine, ts)) * ts == pytest.approx(length, abs=0.51 * ts)


def test_rates_of_slow_samples_have_sixth_order(machine: Machine) -> None:
    """10 Hz at 250 Hz: (w ts)^6/140 = 2e-6 and (w ts)^6/560 = 4e-7, where central differences are
    off by 1 % and 0.5 %. Errors of the next order are a hundredth of these."""
    ts, w = 0.004, 2 * np.pi * 10
    t = ts * np.arange(200)[:, None]
    first, second = rates(machine, np.sin(w * t), ts)
    inner = slice(3, -3)
    off = np.abs(first[inner] / w - np.cos(w * t)[1:-1][inner]).max()
    assert off == pytest.approx((w * ts) ** 6 / 140, rel=0.05)
    off = np.abs(second[inner] / w**2 + np.sin(w * t)[1:-1][inner]).max()
    assert off == pytest.approx((w * ts) ** 6 / 560, rel=0.05)


def test_rows_of_a_slow_log_keep_off_what_is_not_valid(model: MotionModel, fast: Log) -> None:
    """Rates look three samples far at 250 Hz: nothing that a bad sample touches is used."""
    slow = thinned(fast, 16)
    theta = slow["theta"]
    worse, valid = theta.values.copy(), theta.valid.copy()
    worse[1500], valid[1500] = 0.3, False
    marked = replace(theta, values=worse, valid=valid)
    bad = replace(slow, channels={**slow.channels, "theta": marked})
    (clean,), (rows,) = parts(model, slow, 2.0), parts(model, bad, 2.0)
    assert 0 < (~rows.usable).sum() < 40
    # columns of the inertias, which know the rates alone, are the same wherever rows are used
    cols = np.isin(clean.columns.cols, np.arange(132, 138))
    right = clean.columns.values[:, cols]
    # rounding of the convolution
    same = np.abs(rows.columns.values[:, cols] - right) < 1e-9 * np.abs(right).max()
    assert same[rows.usable].all()
    assert not same.all()


@pytest.mark.parametrize("every", [7, 10])
def test_some_rows_are_those_of_all_rows(model: MotionModel, fast: Log, every: int) -> None:
    """The same sums as the convolution's, to their rounding; also where a part ends in between."""
    all_rows = parts(model, fast, 2.0, part=4000)
    for whole, some in zip(all_rows, parts(model, fast, 2.0, 4000, every), strict=True):
        right, size = whole.columns.values[::every], np.abs(whole.columns.values).max(axis=0)
        assert (np.abs(some.columns.values - right) <= 1e-12 * size).all()
        np.testing.assert_allclose(some.tau, whole.tau[::every], rtol=1e-12, atol=1e-14)
        assert np.array_equal(some.time, whole.time[::every])
        assert np.array_equal(some.usable, whole.usable[::every])
