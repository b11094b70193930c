"""Toy systems, built once for all tests of this folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.ssp import toys


@pytest.fixture(scope="session")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the toys' FMUs and .ssp files."""
    return tmp_path_factory.mktemp("toys")


@pytest.fixture(scope="session")
def cache(work: Path) -> Path:
    """Where the executor is compiled for the tests."""
    return work / "lib"


@pytest.fixture(scope="session")
def ring_ssp(work: Path) -> Path:
    """Periods 1, 1, 2, 120 in a ring."""
    return toys.pack(toys.ring(), work)


@pytest.fixture(scope="session")
def narrow_ssp(work: Path) -> Path:
    """The ring with a last relay (4 base steps) that refuses stamps beyond 40."""
    return toys.pack(toys.ring(limit=40.0), work / "narrow")
