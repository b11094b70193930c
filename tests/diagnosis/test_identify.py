"""The fit finds the parameters that made a log, and refuses what no machine could have made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identify import fit, predicted, regression
from flexhex.diagnosis.estimation.motion import MotionModel, dahl_states, motion_model
from flexhex.diagnosis.estimation.rows import on_clock, parts
from flexhex.diagnosis.logs import Channel, Finding, Log
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from tests.conftest import MACHINE_FILE
from tests.diagnosis.sines import NOISE, TS, sines_log
from tests.diagnosis.synthetic import Array


@pytest.fixture(scope="module")
def model(machine: Machine) -> MotionModel:
    return motion_model(machine)


@pytest.fixture(scope="module")
def log(model: MotionModel) -> Log:
    return sines_log(model)


def changed(log: Log, theta: Array | None = None, tau: Array | None = None) -> Log:
    return Log.of(
        log.name, log.ts, log.theta if theta is None else theta, log.tau if tau is None else tau
    )


def test_fit_finds_the_parameters_within_its_own_intervals(machine: Machine, log: Log) -> None:
    fitted = fit(machine, [log])
    off = (fitted.p - base_parameters(machine)) / fitted.std
    # 162 normal values: 4.5 deviations have a chance of a thousandth; too wide is wrong as well
    assert np.abs(off).max() < 4.5
    assert 0.5 < np.sqrt((off**2).mean()) < 1.5
    assert fitted.warnings == ()


def test_wide_interval_counts_as_undetermined(machine: Machine, log: Log) -> None:
    """What is estimated at 1.1 +- 0.87 where the machine file says 0.5 is not determined."""
    loud = log.tau + 0.5 * np.random.default_rng(5).standard_normal(log.tau.shape)
    fitted = fit(machine, [changed(log, tau=loud)])
    nominal = np.abs(base_parameters(machine))
    for par, std, value in zip(parameters(machine), fitted.std, nominal, strict=True):
        if 2 * std > max(value, par.floor):
            assert par.name in fitted.undetermined
        if par.name not in fitted.undetermined:
            assert 2 * std <= max(value, par.floor)
    assert 0 < len(fitted.undetermined) < 162


WRONG: dict[str, tuple[Callable[[Log], Log], str]] = {
    "torque turned": (lambda g: changed(g, tau=-g.tau), "negative upper.* sign of the torque"),
    "angle turned": (lambda g: changed(g, theta=-g.theta), "negative"),
    "joints swapped": (
        lambda g: changed(g, theta=g.theta[:, [3, 1, 2, 0, 4, 5]]),
        "explains only|negative",
    ),
    "one torque turned": (
        lambda g: changed(g, tau=g.tau * [1, 1, -1, 1, 1, 1]),
        "explains only|negative",
    ),
    "all joints equal": (
        lambda g: changed(g, theta=np.repeat(g.theta[:, :1], 6, axis=1)),
        r"cannot tell the parameters apart \(condition",
    ),
    "encoder noise only": (
        lambda g: changed(g, theta=1e-8 * np.random.default_rng(1).standard_normal(g.theta.shape)),
        r"theta\[1\] moves by .* 6 of 6 joints",
    ),
    "one joint still": (
        lambda g: changed(g, theta=g.theta * [1, 1, 1, 0, 1, 1]),
        r"theta\[4\] moves by 0 rad only, 1 of 6",
    ),
    "torque of another motion": (
        lambda g: changed(g, tau=g.tau[::-1].copy()),
        "explains only|negative",
    ),
    "torque dead": (lambda g: changed(g, tau=0 * g.tau), r"tau_meas\[1\] is constant"),
    "degrees": (lambda g: changed(g, theta=57.3 * g.theta), "beyond the stroke .* degrees"),
    "too slow": (
        lambda g: Log.of("slow", 0.02, g.theta, g.tau),
        "slow: 50 samples per second, at least 60 are needed",
    ),
    "too short": (lambda g: Log.of("x", TS, g.theta[:4100], g.tau[:4100]), "too short"),
    "swapped by its reference": (
        lambda g: replace(g, findings=(Finding("swapped", "a.csv", "axes are swapped", False),)),
        "axes are swapped",
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_impossible_log_is_refused(wrong: str, machine: Machine, log: Log) -> None:
    change, message = WRONG[wrong]
    with pytest.raises(LogError, match=message):
        fit(machine, [change(log)])


def test_what_logs_cannot_tell_apart_stays_near_the_machine_file(
    machine: Machine, model: MotionModel, log: Log
) -> None:
    """All joints move as the first one does: each body hides behind the others."""
    theta = np.repeat(log.theta[:, :1], 6, axis=1)
    thetad = np.gradient(theta, TS, axis=0)
    z = dahl_states(theta, machine.actuator.sigma)
    columns = model.columns(theta, z, thetad, np.gradient(thetad, TS, axis=0))
    other = base_parameters(machine)
    preload = [par.name for par in parameters(machine)].index("actuator[1].o")
    other[preload] += 0.5
    noise = NOISE * np.random.default_rng(5).standard_normal(theta.shape)
    together = changed(log, theta=theta, tau=predicted(columns, other) + noise)
    with pytest.raises(LogError, match="cannot tell the parameters apart"):
        fit(machine, [together])
    fitted = fit(machine, [together], tolerance=0.2)
    off = abs(fitted.p[preload] - other[preload])
    assert off < 4 * fitted.std[preload] < 0.3, "which the offset does not"
    assert fitted.residual_rms == pytest.approx(0.2 * NOISE, rel=0.5)
    scale = np.maximum(np.abs(other), [par.floor for par in parameters(machine)])
    assert (np.abs(fitted.p - other) / scale).max() < 0.2
    (warning,) = fitted.warnings
    assert "apart" in warning
    assert warning.endswith("they are kept near the machine file's, 20% of each")
    assert np.array_equal(fit(machine, [log], tolerance=0.2).p, fit(machine, [log]).p)


def test_log_of_the_hexapod_is_refused_for_its_actuators(log: Log) -> None:
    alone = load_machine(MACHINE_FILE.with_name("tflex-actuators.toml"))
    with pytest.raises(LogError, match="tflex-actuators"):
        fit(alone, [log])


def test_wrong_torque_constant_is_reported(machine: Machine, log: Log) -> None:
    fitted = fit(machine, [changed(log, tau=log.tau / 3)])
    assert "0.33 times those of tflex: is the torque constant right" in fitted.warnings[0]


def test_invalid_samples_do_not_touch_the_fit(machine: Machine, log: Log) -> None:
    """A bridged gap and a clipped torque change nothing but the number of rows."""
    theta, tau = log["theta"], log["tau_meas"]
    bad, worse = theta.values.copy(), tau.values.copy()
    bad[9000:9020] = np.linspace(bad[9000], bad[9020], 20)
    worse[15000:15030] = machine.drive.tau_max
    good = np.ones(len(bad), dtype=bool)
    broken, clipped = good.copy(), good.copy()
    broken[9000:9020] = clipped[15000:15030] = False
    holed = replace(
        log,
        channels={
            "theta": replace(theta, values=bad, valid=broken),
            "tau_meas": replace(tau, values=worse, valid=clipped),
        },
    )
    clean, fitted = fit(machine, [log]), fit(machine, [holed])
    assert 0 < clean.samples - fitted.samples < 300
    # other rows, the same parameters: far within the deviations, and no larger residual
    assert np.abs((fitted.p - clean.p) / clean.std).max() < 1.5
    assert fitted.residual_rms == pytest.approx(clean.residual_rms, rel=0.05)
    unmarked = changed(log, tau=worse)
    with pytest.raises(LogError, match="explains only"):
        fit(machine, [unmarked])


def test_settle_starts_anew_after_a_break(model: MotionModel, log: Log) -> None:
    valid = np.ones(len(log.theta), dtype=bool)
    valid[9999] = False
    channels = {
        name: replace(channel, valid=valid, breaks=((10_000, 60.0),))
        for name, channel in log.channels.items()
    }
    (rows,) = parts(model, replace(log, channels=channels), 2.0, part=100_000)
    used = rows.time[rows.usable]
    # nothing within 2 s after the break, which stands at 5 s and ends at 65 s
    assert not ((used > 4.99) & (used < 67.0)).any()
    assert (used < 4.9).any()
    assert used.max() > 71.9


def test_parts_of_a_log_are_the_whole(model: MotionModel, log: Log) -> None:
    columns, tau = regression(model, log, 2.0)
    pieces = list(parts(model, log, 2.0, part=3000))
    values = np.vstack([piece.columns.values for piece in pieces])
    # a sum of 101 products in another order
    assert np.abs(values - columns.values).max() < 1e-11 * np.abs(columns.values).max()
    assert np.abs(np.vstack([piece.tau for piece in pieces]) - tau).max() < 1e-12


def test_torque_on_another_clock_meets_the_angle() -> None:
    """Cubic interpolation of 40 Hz at 1 kHz: h^4 w^4 3/128 = 1e-4 of the amplitude."""
    t = 0.0003 + 0.001 * np.arange(500)
    signal = Channel(0.0003, 0.001, np.sin(250 * t)[:, None], np.ones(500, dtype=bool))
    signal.valid[100] = False
    clock = Channel(0.0, 5e-4, np.zeros((1000, 1)), np.ones(1000, dtype=bool))
    values, valid = on_clock(signal, clock)
    assert np.abs(values[valid, 0] - np.sin(250 * clock.time[valid])).max() < 1.5e-4
    assert not valid[[0, 200, 201]].any()
    assert valid.sum() > 985


def test_slower_torque_gives_the_same_parameters(machine: Machine, log: Log) -> None:
    """Torque at 4 kHz half a sample beside the angle's 2 kHz clock: the rates are not merged."""
    tau = log["tau_meas"]
    t = np.arange(2 * len(tau.values) - 8) * TS / 2 + TS / 4
    known = tau.time
    fine = np.column_stack([np.interp(t, known, c) for c in tau.values.T])
    other = Channel(TS / 4, TS / 2, fine, np.ones(len(t), dtype=bool))
    fitted = fit(machine, [replace(log, channels={"theta": log["theta"], "tau_meas": other})])
    clean = fit(machine, [log])
    assert np.abs((fitted.p - clean.p) / clean.std).max() < 2
