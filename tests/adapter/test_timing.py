"""The timing rule: whole base steps, samples at k Ts from k = 1 on, results at (k + 1) Ts."""

from __future__ import annotations

import ctypes as ct
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


def last_time(slave: Slave) -> float:
    """What fmi2GetRealStatus says of fmi2LastSuccessfulTime."""
    time = ct.c_double()
    assert slave.call("fmi2GetRealStatus", 2, ct.byref(time)) == OK
    return time.value


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


@pytest.mark.parametrize("size", [0.4 * BASE, 1.5 * BASE, 2.00001 * BASE, 2e-9 * BASE, 1e300])
def test_step_that_is_not_whole_is_refused(running: Slave, size: float) -> None:
    """An error, as no part of the step is done; a step of another size may follow."""
    running.advance(3)
    outputs = [place for place in OUT if place != VR["fault"]]
    before = running.get(outputs)
    assert running.step(3 * BASE, size) == ERROR
    (status, category, text) = running.log[-1]
    assert (status, category) == (ERROR, "logStatusError")
    assert text.startswith("fmi2DoStep by ")
    assert text.endswith("must be a whole number of base steps of 0.00025 s (instance one)")
    assert last_time(running) == 3 * BASE
    assert running.get([*outputs, VR["fault"]]) == [*before, 1.0], "nothing but the fault"
    running.advance()


@pytest.mark.parametrize("size", [0.0, -BASE, np.nan, np.inf, -np.inf])
def test_step_without_a_size_is_refused(running: Slave, size: float) -> None:
    running.advance(3)
    assert running.step(3 * BASE, size) == ERROR
    assert running.said.endswith("s, must be above zero and finite (instance one)")
    assert last_time(running) == 3 * BASE
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


TENTHS = 10_000
"""Tenths of a second up to 1000 s."""


def run_to(slave: Slave, time: float, step: float, stop: float) -> float:
    """What tools do: steps of min(step, what is left) until their sum is there; the last size."""
    size = 0.0
    while time < stop:
        size = min(step, stop - time)
        assert slave.step(time, size) == OK, (stop, slave.said)
        time += size
    return size


@pytest.mark.parametrize("steps", [1, 3, 4, 40])
def test_summed_time_ends_at_every_tenth_of_a_second(running: Slave, steps: int) -> None:
    step = steps * BASE
    times = np.concatenate([[0.0], np.cumsum(np.full(int(1000 / step) + 2, step))])
    rests = 0
    for tenth in range(1, TENTHS + 1):
        stop = tenth / 10
        # the sum as it stands two steps earlier; the FMU is there at once
        before = int(np.searchsorted(times, stop)) - 2
        if before * steps > running.n:
            size = (before * steps - running.n) * BASE
            assert running.step(running.n * BASE, size) == OK, running.said
            running.n = before * steps
        state = running.state()
        rests += run_to(running, float(times[before]), step, stop) < 0.01 * BASE
        assert round(last_time(running) / BASE) == tenth * 400
        assert running.restore(state) == OK
        assert running.forget(state) == OK
    assert running.log == []
    assert rests > 1000, "sums of steps leave rests, or nothing was tried"


def test_rest_of_time_does_nothing(running: Slave) -> None:
    running.set(IN, inputs(3))
    running.advance(4)
    before, state = running.get(OUT), running.serialised()
    assert running.step(4 * BASE, 3e-19) == OK
    assert running.step(4 * BASE + 3e-19, 3e-14) == OK
    assert running.step(4 * BASE + 3e-14, 2e-13) == OK
    assert running.get(OUT) == before
    assert running.serialised() == state, "nothing at all"
    running.advance()


def test_tolerance_is_that_of_sums_of_doubles(fresh: Slave) -> None:
    """After n steps n**2 half units in the last place, twice; from 1e-9 to a quarter of a step."""
    # what ticks seldom comes to 400 million base steps soon
    set_period(fresh, 120)
    running = fresh.initialise()
    for count, near, off in [
        (4, 0.9e-9, 1.1e-9),
        (4000, 4000**2 * 2.0**-53, 4000**2 * 2.0**-49),
        (4_000_000, 4e6**2 * 2.0**-53, 4e6**2 * 2.0**-49),
        (400_000_000, 0.24, 0.26),
    ]:
        running.advance(count - running.n)
        assert running.step(count * BASE, off * BASE) == ERROR
        assert running.step((count + off) * BASE, BASE) == ERROR
        assert running.step(count * BASE, near * BASE) == OK
        assert running.step((count + near) * BASE, BASE) == OK
        running.n += 1


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
    assert slave.step(10 * BASE - 1e-18, BASE) == OK


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
