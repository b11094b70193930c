"""The frame loop allocates nothing: five times as many cycles, as many allocations."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.gateway.bench import Bench

SHIM = Path(__file__).with_name("count_malloc.c")


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The counter as a library; skips where the C library is another."""
    library = tmp_path_factory.mktemp("shim") / "count_malloc.so"
    command = ["cc", "-O1", "-fPIC", "-shared", str(SHIM), "-o", str(library)]
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("no cc on the PATH")
    if done.returncode:
        pytest.skip(f"the counter needs glibc: {done.stderr[-200:]}")
    return library


def allocations(shim: Path, ssp: Path, folder: Path, seconds: float) -> int:
    """Calls of malloc and its like in the thread of the cycle, over a whole run."""
    file = folder / "count"
    wrapper = ("env", f"LD_PRELOAD={shim}", f"COUNT_MALLOC_FILE={file}")
    ran = Bench(ssp, folder).run(seconds=seconds, wrapper=wrapper)
    assert ran.code == 0, ran.words
    assert len(ran.table["time"]) >= seconds / 0.00025
    return int(file.read_text())


def test_cycles_allocate_nothing(shim: Path, hexapod_ssp: Path, tmp_path: Path) -> None:
    few = allocations(shim, hexapod_ssp, tmp_path, 0.5)
    many = allocations(shim, hexapod_ssp, tmp_path, 2.5)
    # the counter counts: reading the configuration and the system takes thousands
    assert few > 1000
    # 8000 more cycles; waiting for longer runs of SDO and states may take a few more at the start
    assert abs(many - few) < 100
