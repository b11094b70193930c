"""The timing rule: whole base steps, samples at k Ts from k = 1 on, results at (k + 1) Ts."""

from __future__ import annotations

import random
from pathlib import Path

import fmpy
import numpy as np
import pytest

from tests.adapter.slave import ERROR, OK, Binary, Slave
from tests.adapter.toys import BASE, OUTPUTS, VR, Twin

OUT = [VR[name] for name in OUTPUTS]
IN = [VR[name] for name in ("u", "a[1]", "a[2]", "a[3]")]


def inputs(n: int) -> list[float]:
    """Some input for every base step."""
    return [np.sin(0.3 * n), np.cos(0.1 * n), 0.01 * (n % 17), -1.0]


def set_period(slave: Slave, period: int) -> None:
    assert slave.set([VR["Ts"]], [period * BASE]) == OK


@pytest.mark.parametrize("period", [1, 2, 3, 120])
def test_outputs_follow_the_rule_spelt_out(fresh: Slave, period: int) -> None:
    set_period(fresh, period)
    fresh.initialise()
    twin, rng = Twin(period), random.Random(period)
    for _ in range(300):
        values = inputs(twin.n)
        count = rng.choice([1, 1, 2, 3, 5, period])
        assert fresh.set(IN, values) == OK
        fresh.advance(count)
        # to the last bit: both do the same additions and products in the same order
        assert fresh.get(OUT) == twin.step(count, values[0], values[1:])


def test_first_result_appears_after_two_periods(running: Slave) -> None:
    running.set(IN, [0.25, 0, 0, 0])
    seen = []
    for _ in range(6):
        running.advance()
        seen.append(running.get([VR["y"]])[0])
    assert seen == [0.5, 0.5, 0.5, 1.0, 1.0, 1.0]


def test_input_of_the_first_step_is_never_sampled(running: Slave) -> None:
    running.set(IN, [1.0, 1, 1, 1])
    running.advance()
    running.set(IN, [0.0, 0, 0, 0])
    running.advance(9)
    assert running.get([VR["y"], VR["integral[1]"]]) == [0.5, 0.1]


@pytest.mark.parametrize("seed", range(5))
def test_slices_of_a_step_change_nothing(make, seed: int) -> None:
    whole, sliced, rng = (
        make("whole").initialise(),
        make("sliced").initialise(),
        random.Random(seed),
    )
    for k in range(100):
        for slave in (whole, sliced):
            assert slave.set(IN, inputs(k)) == OK
        left = 6
        whole.advance(left)
        while left:
            count = rng.randint(1, left)
            sliced.advance(count)
            left -= count
        assert whole.get(OUT) == sliced.get(OUT)


@pytest.mark.parametrize(
    "size", [0.0, -BASE, 0.4 * BASE, 1.5 * BASE, 2.00001 * BASE, np.nan, np.inf]
)
def test_step_that_is_not_whole_is_refused(running: Slave, size: float) -> None:
    running.advance(3)
    before = running.get(OUT[:-1])
    assert running.step(3 * BASE, size) == ERROR
    assert "fmi2DoStep by" in running.said
    assert "whole number of base steps of 0.00025 s (instance one)" in running.said
    assert running.get(OUT[:-1]) == before
    running.advance()


@pytest.mark.parametrize("off", [0.3, -0.3, 1.0, 1e6, np.nan, np.inf])
def test_step_from_another_time_is_refused(running: Slave, off: float) -> None:
    running.advance(2)
    assert running.step((2 + off) * BASE, BASE) == ERROR
    assert "but the FMU is at 0.0005 s" in running.said
    running.advance()


def test_summed_time_never_drifts(running: Slave) -> None:
    time = 0.0
    for _ in range(300_000):
        if running.step(time, BASE) != OK:
            break
        time += BASE
    assert running.log == []
    assert time != 75.0  # the importer's sum is off, the instance's count is not
    assert running.get([VR["ticks"]]) == [149_999]


def test_start_time_is_where_counting_begins(make) -> None:
    slave = make().initialise(start=12.345)
    assert slave.step(0.0, BASE) == ERROR
    assert slave.step(12.345, 4 * BASE) == OK
    assert slave.get([VR["ticks"]]) == [1]
    assert slave.step(12.345 + 4 * BASE, BASE) == OK


def test_step_beyond_stop_time_is_refused(make) -> None:
    slave = make().initialise(stop=10 * BASE)
    slave.advance(9)
    assert slave.step(9 * BASE, 2 * BASE) == ERROR
    assert "to 0.00275 s, beyond the stop time 0.0025 s" in slave.said
    slave.advance()
    assert slave.step(10 * BASE, BASE) == ERROR
    # an importer whose summed time falls short of the end takes one step more
    assert slave.step(10 * BASE - 1e-12, BASE) == OK


def test_sample_time_must_be_whole(fresh: Slave) -> None:
    fresh.set([VR["Ts"]], [1.5 * BASE])
    fresh.setup()
    fresh.call("fmi2EnterInitializationMode")
    assert fresh.call("fmi2ExitInitializationMode") == ERROR
    assert fresh.said == (
        "Ts = 0.000375 s, must be a whole number of base steps of 0.00025 s (instance one)"
    )
    fresh.set([VR["Ts"]], [3 * BASE])
    assert fresh.call("fmi2ExitInitializationMode") == OK


def test_fmpy_gives_the_same_rows(toy_fmu: Path, toy: Binary) -> None:
    rows = [(n * BASE, *inputs(n)) for n in range(41)]
    names = ["time", "u", "a[1]", "a[2]", "a[3]"]
    signals = np.array(rows, dtype=[(name, float) for name in names])
    result = fmpy.simulate_fmu(
        str(toy_fmu), stop_time=40 * BASE, output_interval=BASE, input=signals, output=OUTPUTS
    )
    twin, slave = Twin(2), Slave(toy).initialise()
    for n, row in enumerate(result):
        assert [row[name] for name in OUTPUTS] == twin.published == slave.get(OUT)
        slave.set(IN, inputs(n))
        slave.advance()
        twin.step(1, inputs(n)[0], inputs(n)[1:])
    slave.free()


def test_wrong_twin_is_noticed(running: Slave) -> None:
    """The comparison above can fail: a twin that ticks at zero differs."""
    twin = Twin(2)
    twin.n = 2
    running.set(IN, [0.25, 0, 0, 0])
    running.advance(2)
    assert running.get(OUT) != twin.step(2, 0.25, [0, 0, 0])
