"""Instances: made, refused, freed, and whose memory they have."""

from __future__ import annotations

import ctypes as ct

import pytest

from tests.adapter.slave import ERROR, Binary, Slave


def test_freed_instance_is_noticed(fresh: Slave) -> None:
    """As far as it can be: the memory of a freed instance may belong to somebody else."""
    kept: list[object] = []
    allocate, free = _own_memory(kept)
    slave = Slave(fresh.binary, memory=(allocate, free))
    slave.call_free()
    assert slave.call("fmi2Reset") == ERROR
    slave.call_free()


def _own_memory(kept: list[object]) -> tuple[object, object]:
    """An allocator that never gives memory back, so that stale pointers can be tried."""
    from tests.adapter.slave import Allocate, Free

    def allocate(count: int, size: int) -> int:
        kept.append(ct.create_string_buffer(count * size + 16))
        return (ct.addressof(kept[-1]) + 15) // 16 * 16  # type: ignore[arg-type]

    return Allocate(allocate), Free(lambda _: None)


def test_importers_memory_is_used_and_given_back_once(toy: Binary) -> None:
    from tests.adapter.slave import Allocate, Free

    libc, given, back = ct.CDLL(None), [], []
    libc.calloc.restype = ct.c_void_p

    def allocate(count: int, size: int) -> int:
        given.append(int(libc.calloc(ct.c_size_t(count), ct.c_size_t(size))))
        return given[-1]

    def free(memory: int) -> None:
        back.append(memory)
        libc.free(ct.c_void_p(memory))

    slave = Slave(toy, memory=(Allocate(allocate), Free(free)))
    slave.initialise().advance(10)
    slave.get([0, 1])
    assert len(given) == 1
    state = slave.state()
    assert len(given) == 2
    slave.forget(state)
    slave.free()
    assert sorted(given) == sorted(back)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"guid": "{other}"}, "the GUID is not that of this binary"),
        ({"kind": 0}, "this FMU is for co-simulation only"),
        ({"name": ""}, "the instance has no name"),
    ],
)
def test_wrong_instantiation_is_refused(toy: Binary, options: dict, text: str) -> None:
    slave = Slave(toy, **options)
    assert not slave.c
    assert slave.log[0][:2] == (ERROR, "logStatusError")
    assert text in slave.said


def test_versions(toy: Binary) -> None:
    assert toy.library.fmi2GetVersion() == b"2.0"
    assert toy.library.fmi2GetTypesPlatform() == b"default"
