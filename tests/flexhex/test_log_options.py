"""`identify` reads logs as `diagnose` does: units, names and torque constants can be told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.fmus.common.errors import LogError, UsageError
from tests.diagnosis.synthetic import columns, motion, write_csv

WORDS = ["--unit", "theta=deg", "--unit", "tau_meas=A", "--torque-constant", "2.5"]


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Logs that the fit was given."""
    logs: list[Any] = []

    def fit(machine: Any, given: list[Any], settle: float) -> Any:
        logs.extend(given)
        raise LogError("stopped here")

    monkeypatch.setattr("flexhex.diagnosis.estimation.identify.fit", fit)
    return logs


def test_identify_reads_units_names_and_currents_as_given(seen: list[Any], tmp_path: Path) -> None:
    names, _, values = columns(motion(1.0, n=6))
    other = [name.replace("theta", "q") for name in names]
    units = ["s", *[""] * 12]
    path = write_csv(tmp_path / "a.csv", other, units, values)
    done = CliRunner().invoke(app, ["identify", str(path), *WORDS, "--rename", "q=theta"])
    assert "stopped here" in str(done.exception)
    (log,) = seen
    # degrees to radians, amperes to N m
    assert log.theta[7, 2] == pytest.approx(values[7, 3] / 57.29577951308232, rel=1e-12)
    assert log.tau[7, 2] == pytest.approx(2.5 * values[7, 9], rel=1e-12)


def test_identify_names_the_option_that_its_message_asks_for(tmp_path: Path) -> None:
    names, _, values = columns(motion(1.0, n=6))
    path = write_csv(tmp_path / "a.csv", names, ["s", *[""] * 12], values)
    done = CliRunner().invoke(app, ["identify", str(path)])
    assert isinstance(done.exception, LogError)
    assert "--unit theta=rad" in str(done.exception)


def test_identify_refuses_an_option_that_names_nothing() -> None:
    done = CliRunner().invoke(app, ["identify", "a.csv", "--unit", "angle=deg"])
    assert isinstance(done.exception, UsageError)
