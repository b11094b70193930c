"""The table of faults, shared by all tests of a session."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from tests.gateway.fault_table import FALLS, Table

# a shell ignores it in what it starts in the background, and what a test starts there would, too
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def table(request: pytest.FixtureRequest) -> Iterator[Table]:
    """Rows of docs/gateway-faults.md; `--update` writes them."""
    rows = Table(bool(request.config.getoption("--update")))
    yield rows
    rows.write()


@pytest.fixture(scope="session")
def falls(request: pytest.FixtureRequest) -> Iterator[Table]:
    """Rows of the table of falls in docs/gateway-faults.md."""
    rows = Table(bool(request.config.getoption("--update")), FALLS)
    yield rows
    rows.write()
