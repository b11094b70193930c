"""FMU states: back to where it was, in another instance, as bytes; and reset."""

from __future__ import annotations

import ctypes as ct
from pathlib import Path

import pytest

from tests.adapter import toys
from tests.adapter.slave import ERROR, OK, Binary, Slave
from tests.adapter.toys import NAMES, VR
from tests.conftest import OBJECTS

ALL = list(range(len(NAMES)))
HEAD = 40
"""Bytes before the block: format, version, byte order, model, size, checksum."""


def drive(slave: Slave, first: int, count: int) -> list[list[float]]:
    """Some course with changing inputs; all values after every step."""
    seen = []
    for k in range(first, first + count):
        values = [0.01 * (k % 90), 0.1 * (k % 7), -0.2, k * 0.001]
        assert slave.set([VR["u"], VR["a[1]"], VR["a[2]"], VR["a[3]"]], values) == OK
        slave.advance()
        seen.append(slave.get(ALL))
    return seen


def test_state_brings_back_everything(running: Slave) -> None:
    drive(running, 0, 13)
    state, at = running.state(), running.n
    once = drive(running, 13, 25)
    assert running.restore(state) == OK
    running.n = at
    assert drive(running, 13, 25) == once
    assert running.forget(state) == OK


def test_state_is_reused_when_given(running: Slave) -> None:
    state = running.state()
    kept = state.value
    drive(running, 0, 5)
    assert running.call("fmi2GetFMUstate", ct.byref(state)) == OK
    assert state.value == kept
    running.set([VR["u"]], [-1.0])
    assert running.restore(state) == OK
    assert running.get([VR["u"]]) == [0.04]
    running.forget(state)


def test_state_brings_back_phase_and_fault(fresh: Slave) -> None:
    state = fresh.state()
    fresh.initialise()
    fresh.set([VR["u"]], [9.0])
    assert fresh.restore(state) == OK
    fresh.initialise()
    assert fresh.get([VR["fault"]]) == [0.0]
    fresh.forget(state)


def test_bytes_travel_to_another_instance(make) -> None:
    first, second = make("first").initialise(), make("second")
    drive(first, 0, 11)
    status, state = second.deserialise(first.serialised())
    assert status == OK
    assert second.restore(state) == OK
    second.n = first.n
    assert drive(second, 11, 20) == drive(first, 11, 20)
    second.forget(state)


def test_every_damaged_byte_is_noticed(running: Slave) -> None:
    drive(running, 0, 5)
    good = running.serialised()
    for k in range(len(good)):
        bad = bytearray(good)
        bad[k] ^= 0x10
        status, state = running.deserialise(bytes(bad))
        assert status == ERROR, k
        assert not state.value
    assert running.serialised() != good, "fault must be raised by now"


@pytest.mark.parametrize(
    ("cut", "text"),
    [(0, "too few bytes"), (20, "too few bytes"), (HEAD, "missing or too many"), (-1, "missing")],
)
def test_truncated_bytes_are_refused(running: Slave, cut: int, text: str) -> None:
    assert running.deserialise(running.serialised()[:cut])[0] == ERROR
    assert text in running.said


def test_bytes_too_many_are_refused(running: Slave) -> None:
    assert running.deserialise(running.serialised() + b"\0")[0] == ERROR


def test_foreign_bytes_are_refused(running: Slave, tmp_path: Path) -> None:
    assert running.deserialise(bytes(1000))[0] == ERROR
    assert "not a serialised state of a flexhex FMU" in running.said
    data = bytearray(running.serialised())
    data[8] = 2
    assert running.deserialise(bytes(data))[0] == ERROR
    assert "in another version" in running.said
    other = Slave(Binary(toys.build(tmp_path, OBJECTS, offset=0.75), tmp_path / "other"))
    assert other.deserialise(running.serialised())[0] == ERROR
    assert "of another FMU, or of another build" in other.said
    state = running.state()
    assert other.restore(state) == ERROR
    assert other.said == (
        "fmi2SetFMUstate: not a state of this FMU, or one that was freed (instance one)"
    )
    running.forget(state)
    other.free()


def test_null_states(running: Slave) -> None:
    nothing = ct.c_void_p()
    assert running.forget(nothing) == OK
    assert running.call("fmi2FreeFMUstate", None) == OK
    assert running.restore(nothing) == ERROR
    assert running.said == "fmi2SetFMUstate: the state is NULL (instance one)"
    assert running.call("fmi2GetFMUstate", None) == ERROR
    assert running.call("fmi2SerializedFMUstateSize", nothing, None) == ERROR


def test_freed_state_is_gone(running: Slave) -> None:
    state = running.state()
    assert running.call("fmi2FreeFMUstate", ct.byref(state)) == OK
    assert not state.value
    assert running.call("fmi2FreeFMUstate", ct.byref(state)) == OK


def test_too_small_a_buffer_is_refused(running: Slave) -> None:
    state = running.state()
    buffer = (ct.c_char * 10)()
    assert running.call("fmi2SerializeFMUstate", state, buffer, ct.c_size_t(10)) == ERROR
    assert "room for 10 bytes, needs" in running.said
    running.forget(state)


def test_reset_equals_a_fresh_instance(make) -> None:
    fresh, used = make(), make(logging=True)
    used.set([VR["offset"], VR["gain"], VR["Ts"]], [4.0, 3.0, 0.00075])
    used.initialise(stop=9.0)
    drive(used, 0, 33)
    assert used.set([VR["u"]], [3.0]) == ERROR
    assert used.call("fmi2Reset") == OK
    used.n = 0
    assert used.serialised() == fresh.serialised()
    assert drive(used.initialise(), 0, 33) == drive(fresh.initialise(), 0, 33)


def test_instances_are_independent(make) -> None:
    alone = drive(make("alone").initialise(), 0, 30)
    one, two = make("one").initialise(), make("two")
    two.set([VR["offset"]], [-3.0])
    two.initialise()
    beside = []
    for k in range(30):
        beside += drive(one, k, 1)
        drive(two, 7 * k, 1)
    assert beside == alone
    two.free()
    drive(one, 30, 3)
