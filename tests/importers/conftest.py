"""The loop of these tests, built once; what the own executor makes of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexhex.simulation.builder import Builder
from tests.conftest import one_at_a_time
from tests.importers.loop import CASE, Rows, own_rows


@pytest.fixture(scope="session")
def loop_ssp(builder: Builder) -> Path:
    """The adaptive loop around the model, moving from 0.06 s on."""
    with one_at_a_time(builder.out):
        return builder.case(CASE)


@pytest.fixture(scope="session")
def expected(loop_ssp: Path) -> Rows:
    """Every base step."""
    return own_rows(loop_ssp)
