"""The default machine twice: as the oracles read it and as fmus.common does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.oracles.bridge import Numeric, Paths, compiled
from tests.oracles.machine import TFLEX, Machine, read_machine

if TYPE_CHECKING:
    from flexhex.fmus.common.model.model import Model


@pytest.fixture(scope="session")
def machine() -> Machine:
    return read_machine()


@pytest.fixture(scope="session")
def model() -> Model:
    # imported here, so that the oracles' own tests run without fmus
    from flexhex.fmus.common.machine_file import load_machine
    from flexhex.fmus.common.model.model import Model

    return Model(load_machine(TFLEX))


@pytest.fixture(scope="session")
def path(machine: Machine, model: Model) -> Paths:
    """x, xd, xdd by seed; quaternions have the model's signs."""
    return Paths(machine, model.frames.x0)


@pytest.fixture(scope="session")
def torque(model: Model) -> Numeric:
    """tau of x, xd, xdd, chi, p."""
    return compiled([37, 37, 37, 114, 162], model.inverse_dynamics)


@pytest.fixture(scope="session")
def regressor(model: Model) -> Numeric:
    """Phi of x, xd, xdd, chi."""
    return compiled([37, 37, 37, 114], model.regressor)
