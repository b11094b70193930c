"""fmi2GetReal and fmi2SetReal: what is refused, with which words, and that nothing is stored."""

from __future__ import annotations

import ctypes as ct
import math

import pytest

from tests.adapter.slave import ERROR, OK, Slave
from tests.adapter.toys import NAMES, OUTPUTS, VR

QUIET = [VR[name] for name in NAMES if name != "fault"]


def fault(slave: Slave) -> float:
    return slave.get([VR["fault"]])[0]


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("u", 1.9, "u = 1.9 rad, allowed -1 to 1 rad"),
        ("u", math.nan, "u = nan rad, allowed -1 to 1 rad"),
        ("a[3]", -5.000000000000001, "a[3] = -5.000000000000001 N m, allowed -5 to 5 N m"),
        ("a[1]", math.inf, "a[1] = inf N m, allowed -5 to 5 N m"),
        ("gain", -0.1, "gain = -0.1, allowed 0 to 9"),
    ],
)
def test_value_out_of_range_is_refused_and_flagged(
    running: Slave, name: str, value: float, text: str
) -> None:
    running.advance(7)
    before = running.get(QUIET)
    assert fault(running) == 0
    assert running.set([VR["u"], VR[name]], [0.3, value]) == ERROR
    assert running.log == [(ERROR, "logStatusError", f"{text} (instance one)")]
    assert running.get(QUIET) == before, "the good value of the call was stored"
    assert fault(running) == 1


def test_value_without_bounds_must_be_finite(fresh: Slave) -> None:
    assert fresh.set([VR["begin[2]"]], [math.nan]) == ERROR
    assert fresh.said == "begin[2] = nan N m, must be finite (instance one)"
    assert fresh.set([VR["begin[2]"]], [-math.inf]) == ERROR
    assert fresh.set([VR["begin[2]"]], [1e300]) == OK


def test_bounds_themselves_are_allowed(running: Slave) -> None:
    assert running.set([VR["u"], VR["a[1]"]], [1.0, -5.0]) == OK


def test_fault_stays_until_reset(running: Slave) -> None:
    running.set([VR["u"]], [2.0])
    for _ in range(5):
        running.advance()
        assert fault(running) == 1
    assert running.call("fmi2Reset") == OK
    running.initialise()
    assert fault(running) == 0


def test_fault_of_the_block_shows_after_a_refused_call(running: Slave) -> None:
    running.set([VR["u"]], [2.0])
    running.set([VR["u"]], [0.95])
    running.advance(4)
    assert fault(running) == 2, "the block's own fault is not hidden by the 1"
    assert running.try_get([99])[0] == ERROR
    assert fault(running) == 2, "nor by the next refused call"
    running.set([VR["u"]], [0.1])
    running.advance(2)
    assert fault(running) == 1, "and the refused call is not forgotten"


def test_refused_value_leaves_the_course_as_it_was(make) -> None:
    undisturbed, disturbed = make("a").initialise(), make("b").initialise()
    for k in range(20):
        for slave in (undisturbed, disturbed):
            assert slave.set([VR["u"], VR["a[2]"]], [0.02 * k, 1.0]) == OK
        assert disturbed.set([VR["u"], VR["a[2]"]], [0.5, math.nan]) == ERROR
        assert disturbed.step(0.0, 0.0) == ERROR
        assert disturbed.try_get([99])[0] == ERROR
        undisturbed.advance()
        disturbed.advance()
        assert undisturbed.get(QUIET) == disturbed.get(QUIET)


def test_fault_of_the_block_comes_and_goes(running: Slave) -> None:
    running.set([VR["u"]], [0.95])
    running.advance(4)
    assert fault(running) == 2
    running.set([VR["u"]], [0.1])
    running.advance(2)
    assert fault(running) == 0


def test_unknown_reference_is_refused(running: Slave) -> None:
    last = len(NAMES) - 1
    status, values = running.try_get([VR["y"], last + 1])
    assert (status, values) == (ERROR, [-77.0, -77.0])
    assert running.said == (
        f"fmi2GetReal: value reference {last + 1} does not exist, valid are 0 to {last}"
        " (instance one)"
    )
    assert running.set([4294967295], [0.0]) == ERROR
    assert "fmi2SetReal: value reference 4294967295 does not exist" in running.said
    assert fault(running) == 1


@pytest.mark.parametrize("name", OUTPUTS)
def test_output_cannot_be_set(make, name: str) -> None:
    for slave in (make(), make().initialise()):
        assert slave.set([VR[name]], [0.0]) == ERROR
        function = "fmi2SetInteger" if name == "fault" else "fmi2SetReal"
        assert slave.said == f"{function}: {name} is an output and cannot be set (instance one)"


def test_fixed_parameter_is_set_before_the_end_of_initialisation_only(fresh: Slave) -> None:
    assert fresh.set([VR["offset"]], [1.0]) == OK
    fresh.call("fmi2EnterInitializationMode")
    assert fresh.set([VR["begin[1]"]], [2.0]) == OK
    fresh.call("fmi2ExitInitializationMode")
    assert fresh.set([VR["begin[1]"]], [3.0]) == ERROR
    assert "begin[1] is a fixed parameter, set it before fmi2Exit" in fresh.said
    assert fresh.get([VR["offset"], VR["begin[1]"], VR["y"]]) == [1.0, 2.0, 1.0]


def test_tunable_parameter_acts_from_the_next_tick(running: Slave) -> None:
    running.set([VR["u"]], [0.5])
    running.advance(4)
    assert running.set([VR["gain"]], [4.0]) == OK
    assert running.get([VR["y"]]) == [1.5]
    running.advance(2)
    assert running.get([VR["y"]]) == [2.5]


def test_initial_outputs_follow_the_parameters(fresh: Slave) -> None:
    fresh.set([VR["offset"]], [1.0])
    fresh.call("fmi2EnterInitializationMode")
    assert fresh.get([VR["y"]]) == [1.0]
    fresh.set([VR["offset"], VR["begin[3]"]], [2.0, 9.0])
    assert fresh.get([VR["y"], VR["integral[3]"]]) == [2.0, 9.0]
    fresh.set([VR["offset"]], [3.0])
    fresh.call("fmi2ExitInitializationMode")
    assert fresh.get([VR["y"]]) == [3.0]


def test_parameter_that_the_block_refuses(fresh: Slave) -> None:
    fresh.set([VR["offset"]], [7.0])
    fresh.call("fmi2EnterInitializationMode")
    assert fresh.try_get([VR["y"]])[0] == ERROR
    assert fresh.get([VR["offset"]]) == [7.0], "only outputs need the block"
    assert fresh.call("fmi2ExitInitializationMode") == ERROR
    assert fresh.said == "offset = 7, must not be seven (instance one)"
    fresh.set([VR["offset"]], [6.0])
    assert fresh.call("fmi2ExitInitializationMode") == OK


def test_null_arrays_are_refused_and_empty_ones_are_not(running: Slave) -> None:
    one, value = (ct.c_uint * 1)(0), (ct.c_double * 1)(0.0005)
    for function in ("fmi2GetReal", "fmi2SetReal"):
        assert running.call(function, None, ct.c_size_t(0), None) == OK
        for arrays in ((None, value), (one, None)):
            assert running.call(function, arrays[0], ct.c_size_t(1), arrays[1]) == ERROR
            assert running.said == f"{function}: an array is NULL (instance one)"


def test_starts_are_those_of_the_description(fresh: Slave) -> None:
    fresh.call("fmi2EnterInitializationMode")
    listed = fresh.binary.xml.findall("ModelVariables/ScalarVariable")
    assert [v.get("name") for v in listed] == list(NAMES)
    starts = {v.get("name"): v[0].get("start") for v in listed}
    for name, start in starts.items():
        if start is not None:
            assert fresh.get([VR[str(name)]]) == [float(start)]


def test_bounds_are_those_of_the_description(fresh: Slave) -> None:
    for v in fresh.binary.xml.findall("ModelVariables/ScalarVariable"):
        if v.get("causality") == "output":
            continue
        for bound, beyond in (("min", -math.inf), ("max", math.inf)):
            text = v[0].get(bound)
            if text is not None:
                reference = [int(str(v.get("valueReference")))]
                assert fresh.set(reference, [float(text)]) == OK
                assert fresh.set(reference, [math.nextafter(float(text), beyond)]) == ERROR
