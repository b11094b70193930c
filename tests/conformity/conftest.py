"""The test block's FMU, built once for all tests of this folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.adapter import toys
from tests.conftest import OBJECTS


@pytest.fixture(scope="session")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """toy.fmu with a sample time of two base steps."""
    return toys.build(tmp_path_factory.mktemp("toy"), OBJECTS)
