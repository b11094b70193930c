"""The toy FMU, built once; instances that are freed after each test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.adapter import toys
from tests.adapter.slave import Binary, Slave
from tests.conftest import OBJECTS

Make = Callable[..., Slave]


@pytest.fixture(scope="session")
def toy_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """toy.fmu with a sample time of two base steps."""
    return toys.build(tmp_path_factory.mktemp("toy"), OBJECTS)


@pytest.fixture(scope="session")
def toy(toy_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Binary:
    """The toy, loaded."""
    return Binary(toy_fmu, tmp_path_factory.mktemp("unpacked"))


@pytest.fixture
def make(toy: Binary) -> Iterator[Make]:
    """Makes instances of the toy."""
    instances: list[Slave] = []

    def instance(name: str = "one", **options: object) -> Slave:
        slave = Slave(toy, name, **options)  # type: ignore[arg-type]
        instances.append(slave)
        return slave

    yield instance
    for slave in instances:
        if slave.c:
            slave.free()


@pytest.fixture
def fresh(make: Make) -> Slave:
    """An instance just made."""
    return make()


@pytest.fixture
def running(make: Make) -> Slave:
    """An instance ready for its first step."""
    return make().initialise()
