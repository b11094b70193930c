"""Drives that answer late: a lag is told from a delay by what it loses, or nothing is said.

Commands are sums of sines, so that what a lag or a delay makes of them is known in closed form.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.drives import drives, late
from flexhex.diagnosis.drives.path import PathBase, driven
from flexhex.diagnosis.hypotheses.own_effect import sought
from flexhex.diagnosis.jointfit.effects import SelectedEffect
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.fmus.common.effects import library

Array = NDArray[np.float64]
AXIS_3: Any = SimpleNamespace(id=late.LAG, axis=2)
N, TS, SECONDS, LOOP = 3, 5e-4, 12.0, 2e-4
USUAL = np.full(N, 0.8)
"""Axes, sample time [s], length [s], lag of every current loop [s]."""


def sines(t: Array, trajectory: int, axis: int, times: tuple[float, ...], delay: float) -> Array:
    """Torque (samples,) [N m] of a command behind lags `times` and a delay [s]."""
    rng = np.random.default_rng([trajectory, axis])
    f, phase = rng.uniform(0.3, 25.0, 12), rng.uniform(0, 2 * np.pi, 12)
    w = 2 * np.pi * f
    through = np.exp(-1j * w * delay) / np.prod([1 + 1j * w * T for T in times], axis=0)
    waves = np.exp(1j * (np.outer(t, w) + phase)) * through
    return np.asarray(waves.imag @ (3.0 / (1 + f)))


def runs(lags: tuple[float, ...] = (), delay: float = 0.0, dropped: float = 0.0) -> list[Run]:
    """Two trajectories, each run twice; axis 2 is late, all have the lag of their loops."""
    listed, t = [], TS * np.arange(round(SECONDS / TS))
    for trajectory in (1, 2):
        for number in (1, 2):
            rng = np.random.default_rng([trajectory, number, 7])
            commanded, reported = np.empty((2, len(t), N))
            for i in range(N):
                own = (lags, delay) if i == 1 else ((), 0.0)
                # what is commanded has no lag: the loop's is in what is reported
                commanded[:, i] = sines(t, trajectory, i, (0.0,), 0.0)
                reported[:, i] = sines(t, trajectory, i, (LOOP, *own[0]), own[1])
            reported += 5e-3 * rng.standard_normal(reported.shape)
            valid = rng.random(len(t)) >= dropped
            signals = [
                TimeSeries(0.0, TS, np.round(x / 3e-3) * 3e-3, valid) for x in (reported, commanded)
            ]
            still = np.zeros((len(t) // 2, N))
            motion = Motion(0.0, 2 * TS, still, still, still)
            good = np.ones(len(still), dtype=bool)
            listed.append(Run(f"{trajectory}{number}", str(trajectory), motion, good, *signals))
    return listed


def lateness_of(listed: list[Run], about: float, off: float = 0.0) -> tuple[str, float]:
    """What axis 2 is said to be, about so late, and the time [s] that is told.

    off: error of the common lag [s].
    """
    path = PathBase(USUAL, 0.0105, 0.005, 1.0)
    common = drives.common_lag(path, listed)
    assert common == pytest.approx(LOOP, rel=0.02)
    answer = late.lag_or_delay(path, listed, common + off, {1: about}, [1])
    return (answer[1].id, answer[1].time) if answer else ("", np.nan)


def test_lag_is_distinguished_from_a_delay() -> None:
    assert lateness_of(runs(lags=(1.5e-3,)), 1.3e-3) == (late.LAG, pytest.approx(1.5e-3, rel=0.05))


def test_delay_is_distinguished_from_a_lag() -> None:
    assert lateness_of(runs(delay=1.5e-3), 1.3e-3) == (late.DELAY, pytest.approx(1.5e-3, rel=0.05))


def test_late_axis_that_the_search_left_out_is_no_measure_for_others() -> None:
    """Of a drive so late that its first order explained too little only the others were named."""
    listed = [replace(run, tau=replace(run.tau, values=run.tau.values.copy())) for run in runs()]
    slow = runs(lags=(6e-3,))
    for run, other in zip(listed, slow, strict=True):
        run.tau.values[:, 1] = other.tau.values[:, 1]
        t = run.tau.t0 + TS * np.arange(len(run.tau.values))
        run.tau.values[:, 2] = sines(t, int(run.trajectory), 2, (LOOP, 2e-3), 0.0)
    path = PathBase(USUAL, 0.0105, 0.005, 1.0)
    common = drives.common_lag(path, listed)
    side: Any = SimpleNamespace(fit=SimpleNamespace(effects=[SelectedEffect(late.LAG, (AXIS_3,))]))
    lateness = drives._late(side, path, listed, common)
    assert {axis: one.id for axis, one in lateness.items()} == {1: late.LAG, 2: late.LAG}
    assert lateness[1].time == pytest.approx(6e-3, rel=0.02)


@pytest.mark.parametrize("still", [(2,), (0, 2)])
def test_drive_that_is_asked_for_nothing_says_nothing(still: tuple[int, ...]) -> None:
    listed = runs(lags=(1.5e-3,))
    for run in listed:
        assert run.command is not None
        run.command.values[:, still] = 0.0
        run.tau.values[:, still] = np.round(run.tau.values[:, still] * 1e-3, 3)
    path = PathBase(USUAL, 0.0105, 0.005, 1.0)
    common = drives.common_lag(path, listed)
    moving = [i for i in range(N) if i not in still]
    assert common == pytest.approx(LOOP if 0 in moving else LOOP + 1.5e-3, rel=0.05)
    lateness = late.lag_or_delay(path, listed, LOOP, {1: 1.5e-3}, [1])
    assert {axis: one.id for axis, one in lateness.items()} == (
        {1: late.LAG} if 0 in moving else {}
    )


def test_long_common_lag_is_found_whole() -> None:
    """Reports that come 24 samples late: the derivative of the command says a sixth less."""
    later = 24 * TS
    listed = [replace(run, tau=replace(run.tau, t0=run.tau.t0 + later)) for run in runs()]
    lag = drives.common_lag(PathBase(USUAL, 0.0105, 0.005, 1.0), listed)
    assert lag == pytest.approx(LOOP + later, abs=2e-5)


def test_no_drive_that_moves_has_no_lag() -> None:
    listed = runs()
    for run in listed:
        assert run.command is not None
        run.command.values[:] = 0.0
    assert drives.common_lag(PathBase(USUAL, 0.0105, 0.005, 1.0), listed) == 0.0


def test_gain_between_command_and_report_is_no_limit() -> None:
    """All torques of an axis 3 % small: a limit far below all torques takes away as much."""
    small = np.array([1.0, 0.97, 1.0])
    listed = [replace(run, tau=replace(run.tau, values=run.tau.values * small)) for run in runs()]
    path = PathBase(USUAL, 0.0105, 0.005, 1.0)
    settled: Any = SimpleNamespace(base=path, spacing=path.spacing, torque_rms=USUAL)
    (side,) = drives.drives_of(settled, listed, listed[2:])
    (effect,) = side.named
    assert (effect.id, effect.axes) == ("drive_gain", (2,))
    (gain,) = effect.parameters.values()
    # reported is 0.97 of the command, which is the report and 3.1 % of it
    assert gain.value == pytest.approx(1 / 0.97 - 1, rel=0.05)


def test_run_without_a_known_command_is_all_unknown() -> None:
    run = runs()[0]
    assert run.command is not None
    lost = replace(run.command, valid=np.zeros_like(run.command.valid))
    (unknown,) = driven([replace(run, command=lost)], 0.0)
    assert not unknown.valid.any()
    assert np.isfinite(unknown.tau.values).all()


def test_what_is_half_a_lag_is_not_reported() -> None:
    """Two lags of half the time lose half as much."""
    assert lateness_of(runs(lags=(1.5e-3, 1.5e-3)), 3e-3)[0] == ""


def test_what_loses_more_than_a_lag_is_not_reported() -> None:
    """A lag whose phase is led: half as late as it loses."""
    assert lateness_of(runs(lags=(2e-3,), delay=-1e-3), 1e-3)[0] == ""


def test_time_is_counted_from_the_other_drives() -> None:
    estimate = lateness_of(runs(lags=(1.5e-3,)), 1.3e-3, off=1e-4)
    assert estimate == (late.LAG, pytest.approx(1.5e-3, rel=0.03))


def test_limits_are_sought_behind_the_report_with_a_corner_only() -> None:
    """What gives way gradually there is the motor's iron."""
    known = sought({})
    sharp = next(s for s in known["torque_saturation"].shapes if s.name == "p")
    assert len(sharp.grid) == 1
    assert known.keys() == library().keys()


def test_little_is_not_reported() -> None:
    assert lateness_of(runs(lags=(1e-4,)), 1e-4)[0] == ""


def test_dropped_samples_make_no_jumps() -> None:
    """With zeros in their place the lag of the loops came out at half of what it is."""
    lag = runs(lags=(1.5e-3,), dropped=2e-3)
    assert lateness_of(lag, 1.3e-3) == (late.LAG, pytest.approx(1.5e-3, rel=0.05))


@pytest.mark.parametrize("name", [late.LAG, late.DELAY])
def test_late_command_is_exact(name: str) -> None:
    """Against the closed form; a cubic spline leaves about (w ts)^4 / 400 of a sine: 2e-6."""
    t = 1e-3 * np.arange(4000)
    u = sines(t, 1, 1, (0.0,), 0.0)
    lags, delay = ((2e-3,), 0.0) if name == late.LAG else ((0.0,), 2e-3)
    delayed = late.Late(name, 2e-3, "").of(u, 1e-3)
    settled = t > 0.05
    wanted = sines(t, 1, 1, lags, delay)
    np.testing.assert_allclose(delayed[settled], wanted[settled], rtol=0, atol=1e-5)
    assert np.abs(u - wanted)[settled].max() > 0.2


def test_common_lag_is_that_of_all_axes_which_noise_alone_sets_apart() -> None:
    lags, sds = [410e-6, 485e-6, 489e-6, 437e-6], np.array([75e-6, 42e-6, 23e-6, 55e-6])
    by_hand = np.sum(np.array(lags) / sds**2) / np.sum(1 / sds**2)
    # not 410: the least of them
    assert drives.quickest(lags, list(sds**2)) == pytest.approx(by_hand, rel=1e-12)


def test_common_lag_leaves_out_slow_axes_though_they_be_most() -> None:
    lags, variances = [500e-6, 3e-3, 510e-6, 3.1e-3, 3e-3, 3e-3], [1e-10] * 6
    assert drives.quickest(lags, variances) == pytest.approx(505e-6, rel=1e-12)
