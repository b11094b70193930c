"""Which call is allowed when: the table of FMI 2.0.4, section 4.2.4, typed in anew."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable

import pytest

from tests.adapter.slave import DISCARD, ERROR, OK, Binary, Slave
from tests.adapter.toys import BASE, VR

STATES = ("Instantiated", "InitializationMode", "StepComplete", "Terminated")


# one letter a state, in that order; the states of unfinished and failed steps do not occur
TABLE = {
    "fmi2SetDebugLogging": "xxxx",
    "fmi2SetupExperiment": "x---",
    "fmi2EnterInitializationMode": "x---",
    "fmi2ExitInitializationMode": "-x--",
    "fmi2Terminate": "--x-",
    "fmi2Reset": "xxxx",
    "fmi2GetReal": "-xxx",
    "fmi2GetInteger": "-xxx",
    "fmi2GetBoolean": "-xxx",
    "fmi2GetString": "-xxx",
    "fmi2SetReal": "xxx-",
    "fmi2SetInteger": "xxx-",
    "fmi2SetBoolean": "xxx-",
    "fmi2SetString": "xxx-",
    "fmi2GetFMUstate": "xxxx",
    "fmi2SetFMUstate": "xxxx",
    "fmi2FreeFMUstate": "xxxx",
    "fmi2SerializedFMUstateSize": "xxxx",
    "fmi2SerializeFMUstate": "xxxx",
    "fmi2DeSerializeFMUstate": "xxxx",
    "fmi2GetDirectionalDerivative": "-xxx",
    "fmi2SetRealInputDerivatives": "xxx-",
    "fmi2GetRealOutputDerivatives": "--xx",
    "fmi2DoStep": "--x-",
    "fmi2CancelStep": "----",
    "fmi2GetStatus": "--xx",
    "fmi2GetRealStatus": "--xx",
    "fmi2GetIntegerStatus": "--xx",
    "fmi2GetBooleanStatus": "--xx",
    "fmi2GetStringStatus": "--xx",
}
NOTHING = (None, ct.c_size_t(0))
DO_STEP_STATUS, PENDING_STATUS, LAST_TIME, TERMINATED = range(4)


def bring(slave: Slave, state: str) -> Slave:
    """Take a fresh instance to a state."""
    wanted = STATES.index(state)
    steps = ("fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate")
    for function in steps[:wanted]:
        assert slave.call(function) == OK
    return slave


def arguments(function: str, slave: Slave) -> tuple[object, ...]:
    """Good arguments, such that only the state can be wrong."""
    state = slave.state()
    size = ct.c_size_t()
    assert slave.call("fmi2SerializedFMUstateSize", state, ct.byref(size)) == OK
    data = (ct.c_char * size.value)()
    assert slave.call("fmi2SerializeFMUstate", state, data, size) == OK
    one, value = (ct.c_uint * 1)(VR["u"]), (ct.c_double * 1)(0.5)
    real, whole, text, copy = ct.c_double(), ct.c_int(), ct.c_char_p(), ct.c_void_p()
    special: dict[str, tuple[object, ...]] = {
        "fmi2SetDebugLogging": (0, ct.c_size_t(0), None),
        "fmi2SetupExperiment": (0, real, real, 0, real),
        "fmi2GetReal": (one, ct.c_size_t(1), value),
        "fmi2SetReal": (one, ct.c_size_t(1), value),
        "fmi2GetFMUstate": (ct.byref(copy),),
        "fmi2SetFMUstate": (state,),
        "fmi2FreeFMUstate": (ct.byref(state),),
        "fmi2SerializedFMUstateSize": (state, ct.byref(size)),
        "fmi2SerializeFMUstate": (state, data, size),
        "fmi2DeSerializeFMUstate": (data, size, ct.byref(copy)),
        "fmi2GetDirectionalDerivative": (*NOTHING, *NOTHING, None, None),
        "fmi2SetRealInputDerivatives": (*NOTHING, None, None),
        "fmi2GetRealOutputDerivatives": (*NOTHING, None, None),
        "fmi2DoStep": (real, ct.c_double(BASE), 1),
        "fmi2GetStatus": (DO_STEP_STATUS, ct.byref(whole)),
        "fmi2GetRealStatus": (LAST_TIME, ct.byref(real)),
        "fmi2GetIntegerStatus": (DO_STEP_STATUS, ct.byref(whole)),
        "fmi2GetBooleanStatus": (TERMINATED, ct.byref(whole)),
        "fmi2GetStringStatus": (PENDING_STATUS, ct.byref(text)),
    }
    typed = function.removeprefix("fmi2Get").removeprefix("fmi2Set")
    if typed in ("Integer", "Boolean", "String"):
        return (*NOTHING, None)
    return special.get(function, ())


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("function", TABLE)
def test_call_is_allowed_exactly_where_the_standard_says(
    fresh: Slave, function: str, state: str
) -> None:
    bring(fresh, state)
    legal = TABLE[function][STATES.index(state)] == "x"
    # there is no status of type Integer to ask for
    good = DISCARD if function == "fmi2GetIntegerStatus" else OK
    status = fresh.call(function, *arguments(function, fresh))
    assert status == (good if legal else ERROR), fresh.said
    if not legal:
        assert fresh.said == f"{function} is not allowed in state {state} (instance one)"


@pytest.mark.parametrize("state", STATES)
def test_instance_can_be_freed_in_every_state(fresh: Slave, state: str) -> None:
    bring(fresh, state)
    fresh.free()
    assert fresh.log == []


def test_refused_call_does_not_change_the_state(fresh: Slave) -> None:
    assert fresh.step(0.0, BASE) == ERROR
    fresh.initialise()
    assert fresh.call("fmi2EnterInitializationMode") == ERROR
    fresh.advance()


def test_table_covers_every_exported_function(toy: Binary) -> None:
    header = next(iter(toy.folder.glob("sources/fmi2Functions.h"))).read_text()
    common, cosimulation = header.split("Functions for FMI2 for Co-Simulation")[::2]
    names = {
        word.rstrip(";")
        for text in (common.split("Functions for FMI2 for Model Exchange")[0], cosimulation)
        for word in text.replace("fmi2FullName(", " ").replace(")", " ").split()
        if word.startswith("fmi2") and "TYPE" not in word and "." not in word
    }
    exempt = {"fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate", "fmi2FreeInstance"}
    functions = {n for n in names if hasattr(toy.library, n)}
    assert functions - exempt == set(TABLE)


def test_null_instance_is_refused_without_a_crash(toy: Binary) -> None:
    nobody = Slave(toy, guid="{none}")
    assert not nobody.c
    for function in TABLE:
        assert nobody.call(function, *([None] * 6)) == ERROR, function
    nobody.call_free()


Checked = Callable[[Slave], None]


@pytest.mark.parametrize("times", [(float("nan"), None), (1.0, 0.5), (0.0, float("nan"))])
def test_wrong_experiment_is_refused(fresh: Slave, times: tuple[float, float | None]) -> None:
    assert fresh.setup(*times) == ERROR
    assert "must be finite and in order" in fresh.said


def test_start_beside_which_a_step_is_lost_is_refused(fresh: Slave) -> None:
    assert fresh.setup(1e300) == ERROR
    assert "base steps of 0.00025 s are lost beside 1e+300 s" in fresh.said
    assert fresh.setup(-1e9) == OK
    for function in ("fmi2EnterInitializationMode", "fmi2ExitInitializationMode"):
        assert fresh.call(function) == OK
    assert fresh.step(-1e9, BASE) == OK
    assert fresh.step(-1e9, BASE) == ERROR, "the next step begins one base step later"


def test_status_functions(running: Slave) -> None:
    running.advance(3)
    time, flag, text, whole = ct.c_double(), ct.c_int(7), ct.c_char_p(), ct.c_int(7)
    assert running.call("fmi2GetRealStatus", LAST_TIME, ct.byref(time)) == OK
    assert time.value == 3 * BASE
    assert running.call("fmi2GetBooleanStatus", TERMINATED, ct.byref(flag)) == OK
    assert flag.value == 0
    assert running.call("fmi2GetStringStatus", PENDING_STATUS, ct.byref(text)) == OK
    assert text.value == b""
    assert running.call("fmi2GetStatus", DO_STEP_STATUS, ct.byref(whole)) == OK
    assert whole.value == OK
    assert running.call("fmi2GetStatus", LAST_TIME, ct.byref(whole)) == DISCARD
    assert running.call("fmi2GetRealStatus", LAST_TIME, None) == ERROR


@pytest.mark.parametrize("kind", ["Integer", "Boolean", "String"])
def test_other_types_than_real_are_refused_by_name(running: Slave, kind: str) -> None:
    one, value = (ct.c_uint * 1)(0), (ct.c_void_p * 1)()
    for verb in ("Get", "Set"):
        real = f"Ts is a Real, use fmi2{verb}Real"
        why = "this FMU has no String variables" if kind == "String" else real
        assert running.call(f"fmi2{verb}{kind}", one, ct.c_size_t(1), value) == ERROR
        assert running.said == f"fmi2{verb}{kind}: {why} (instance one)"


@pytest.mark.parametrize(
    ("function", "more"),
    [("fmi2SetRealInputDerivatives", 2), ("fmi2GetRealOutputDerivatives", 2)],
)
def test_derivatives_are_refused(running: Slave, function: str, more: int) -> None:
    one = (ct.c_uint * 1)(VR["u"])
    assert running.call(function, one, ct.c_size_t(1), *[None] * more) == ERROR
    assert function in running.said


def test_directional_derivative_is_refused(running: Slave) -> None:
    one, n = (ct.c_uint * 1)(VR["y"]), ct.c_size_t(1)
    assert running.call("fmi2GetDirectionalDerivative", one, n, one, n, None, None) == ERROR
    assert "providesDirectionalDerivative is false" in running.said
