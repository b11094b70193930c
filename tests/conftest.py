"""Fixtures that all test blocks share: the machine, the built FMUs, the system descriptions."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from flexhex.fmugen import cache as store
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.simulation.builder import Builder
from tests import sampling, skips

ROOT = Path(__file__).resolve().parent.parent
MACHINE_FILE = ROOT / "machines" / "tflex.toml"
OUT = ROOT / "out" / "test"
# one cache for the tests, none of the user's; a warning of the compiler fails them
os.environ.setdefault("FLEXHEX_CACHE", str(ROOT / "out" / "cache"))
os.environ.setdefault("FLEXHEX_WERROR", "1")
OBJECTS = store.objects(OUT / "cache")
"""Object files of whatever C a test compiles as the product does: by content, each of them once."""
for folder in (OUT, OBJECTS):
    folder.mkdir(parents=True, exist_ok=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--update` writes golden results anew, `--all` runs what `make test` samples."""
    parser.addoption("--update", action="store_true", help="write golden results anew")
    parser.addoption("--all", action="store_true", help="run slow and sampled suites in full")


def pytest_configure(config: pytest.Config) -> None:
    """Samples of large suites; a list of allowed skips."""
    listed = sampling.read(sampling.LIST)
    config.pluginmanager.register(sampling.Sampling(config, listed))
    config.pluginmanager.register(skips.Skips(skips.read(skips.LIST)))


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Only one of several test processes builds; the others then find everything cached."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture(autouse=True)
def _same_folder() -> Iterator[None]:
    """FMPy enters an FMU's folder to load it, and stays there when that fails."""
    before = Path.cwd()
    yield
    os.chdir(before)


@pytest.fixture(scope="session")
def machine() -> Machine:
    """The default machine."""
    return load_machine(MACHINE_FILE)


@pytest.fixture(scope="session")
def builder() -> Builder:
    """FMUs and system descriptions of the default machine, built under out/test."""
    building = Builder(MACHINE_FILE, OUT)
    with one_at_a_time(OUT):
        building.systems()
    return building


@pytest.fixture(scope="session")
def fmu_dir(builder: Builder) -> Path:
    """Folder with the nominal FMUs and machine.fmu."""
    return builder.out / "fmus"


@pytest.fixture(scope="session")
def hexapod_ssp(builder: Builder) -> Path:
    """The adaptive loop around the model."""
    return builder.out / "hexapod.ssp"


@pytest.fixture(scope="session")
def machine_ssp(builder: Builder) -> Path:
    """The adaptive loop around machine.fmu."""
    return builder.out / "machine" / "hexapod.ssp"
