"""What the benchmarks compare does the same work; no time is asserted here."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import __main__ as command
from benchmarks import diagnosis, kalman, parallel, tables
from benchmarks.adapter import N, ours, switching
from benchmarks.blocks import block
from benchmarks.clock import Rival, Row, Timing, measure
from benchmarks.dense import dense
from benchmarks.growth import wider
from benchmarks.motion import ROWS, estimator_rows, kinematics, motion
from flexhex.diagnosis.logs import read_log
from flexhex.fmus.common.errors import RunError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.fmus.estimator.interface import normalisation, process_noise
from tests.compare import assert_close


def test_structured_and_dense_forms_agree_to_1e_12(machine: Machine) -> None:
    rows = np.hstack(motion(machine.timing.feedforward))
    structured, paper = kinematics(machine), dense(machine, rows)
    # ticks that are prime to the period: other poses every time, prediction and all
    for _ in range(60):
        structured.ticks(67)
        paper.ticks(67)
        for name in ("x", "xd", "xdd"):
            assert_close(structured.output(name), paper.output(name), rtol=1e-12, what=name)
    assert structured.output("converged") == 1
    assert_close(structured.output("residual"), paper.output("residual"), atol=1e-14)


def test_motion_is_periodic_and_its_rates_are_derivatives() -> None:
    theta, thetad, thetadd = motion(0.001)
    # central differences of a harmonic: off by (w h)^2 / 6, w below 10 rad/s, h = 1 ms
    for f, fd in ((theta, thetad), (thetad, thetadd)):
        slope = (np.roll(f, -1, axis=0) - np.roll(f, 1, axis=0)) / 0.002
        assert_close(slope, fd, rtol=1e-4)
    assert theta.shape == (ROWS, 6)


@pytest.mark.parametrize("update", [kalman.textbook, kalman.joseph])
def test_rival_filters_estimate_as_the_estimator_does(
    machine: Machine, update: Callable[..., Any]
) -> None:
    rows = estimator_rows(machine, 20)
    rows[:, -6:] += np.random.default_rng(3).normal(0, 0.1, (20, 6))
    K = block("estimator", machine, rows, t_start=0.0)
    H, y = kalman.normalised_rows(machine, rows)
    scale = normalisation(machine, base_parameters(machine))
    c = machine.control
    P, q = c.P0 * np.eye(len(scale)), base_parameters(machine) / scale
    for k in range(20):
        K.ticks(1)
        P, q = update(P, q, H[k], y[k], process_noise(machine), c.R2)
    # the textbook's form loses some digits: P0 / R2 times rounding
    assert_close(K.output("p") / scale, q, rtol=1e-8)
    assert_close(K.output("p_std") / scale, np.sqrt(np.diag(P)), rtol=1e-6)
    assert np.max(np.abs(q - base_parameters(machine) / scale)) > 1e-4


def test_adapters_are_not_refused_and_carry_what_was_set(machine: Machine) -> None:
    for slave in (ours(machine), switching(machine)):
        assert slave.run(250) >= 0
        assert slave.c.done == 250
    values = switching(machine).keep[2]
    assert values.shape == (2 * N,)


def test_slave_tells_of_a_refused_call(machine: Machine) -> None:
    slave = ours(machine)
    slave.keep[2][:N] = np.nan
    with pytest.raises(ValueError, match="refused"):
        slave.run(3)


def test_wider_estimator_has_distinct_columns(machine: Machine) -> None:
    for n_p in (162, 600):
        interface, functions = wider(machine, n_p)
        columns = np.array(functions[1]()["columns"]).reshape(machine.n_arms, -1)
        assert interface.constants["WIDTH"] == columns.shape[1]
        assert set(columns.ravel()) == set(range(n_p))
        assert all(len(set(row)) == len(row) for row in columns.tolist())


def test_measure_takes_rivals_in_turn() -> None:
    order: list[str] = []

    def rival(name: str, ns: float) -> Rival:
        def run(count: int) -> float:
            order.append(name)
            return ns

        return Rival(name, run)

    result = measure([rival("a", 2e6), rival("b", 6e6)], rounds=5)
    assert order[-10:] == ["a", "b"] * 5
    assert [t.median for t in result] == [2e6, 6e6]


def test_row_judges_limits_and_ratios_either_way() -> None:
    slow = Row("k", "what", [Timing("a", 3e3, 2e3), Timing("b", 9e3, 9e3)], 2e3, 1e3)
    assert (slow.met(slow.required), slow.met(slow.stretch), slow.ratio(slow.timings[1])) == (
        False,
        False,
        3,
    )
    fast = Row("k", "what", [Timing("a", 12, 13), Timing("b", 3, 3)], 5, 12, faster=True)
    assert (fast.met(fast.required), fast.met(fast.stretch), fast.ratio(fast.timings[1])) == (
        True,
        True,
        4,
    )
    assert tables.quantity(1500.0, False) == "1.5 us"
    assert tables.quantity(2.5e6, False) == "2.5 ms"
    assert tables.quantity(1.25e9, False) == "1.25 s"
    assert tables.quantity(12.0, True) == "12 x"


def test_command_prints_json(capsys: pytest.CaptureFixture[str]) -> None:
    command.main(["--json", "--only", "N", "--rounds", "3"])
    data = json.loads(capsys.readouterr().out)
    assert data["rows"][0]["key"] == "N"
    assert data["rows"][0]["ratios"]


def test_command_refuses_too_few_rounds(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        command.main(["--rounds", "1"])
    assert stop.value.code == 2
    assert "--rounds 1: at least 3" in capsys.readouterr().err


def test_diagnosis_that_is_timed_is_of_four_runs_of_twelve_seconds(tmp_path: Path) -> None:
    *paths, base, name = diagnosis.axis(tmp_path / "logs", tmp_path / "truth")
    logs = [read_log(Path(path)) for path in paths]
    assert (base, name, len(logs)) == ("--base", "axis", 4)
    assert all(len(log.theta) * log.ts == pytest.approx(12.0) for log in logs)


def test_diagnosis_that_fails_has_no_time(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="exit 3"):
        diagnosis.used(["diagnose", "no.csv"], tmp_path)


def test_side_by_side_leaves_out_what_comes_before() -> None:
    def work(amount: float) -> None:
        time.sleep(0.1 + amount)

    clock, _ = parallel.side_by_side(work, 0.05, 2, [])
    # two at a time: twice the amount in a second; sleeps last longer than asked by little
    assert clock == pytest.approx(2.0, rel=0.2)


def test_plain_c_is_busy_on_every_core() -> None:
    gains = parallel.own(sorted(os.sched_getaffinity(0)) * 2)
    assert set(gains) == set(parallel.KINDS)
    assert all(np.isfinite(gain) for gain in gains.values())
