"""`flexhex convert`: runs of all kinds in other formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from flexhex.convert.command import convert_command
from flexhex.diagnosis.logs import read_log
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.results import load, save
from tests.flexhex.test_view import run_of


@pytest.fixture
def app() -> typer.Typer:
    application = typer.Typer()
    application.command("convert")(convert_command)
    application.callback()(lambda: None)
    return application


def converted(app: typer.Typer, source: Path, target: Path) -> Path:
    done = CliRunner().invoke(app, ["convert", str(source), str(target)])
    assert done.exit_code == 0, done.output
    return target


def test_result_is_the_same_after_a_turn_through_csv(app: typer.Typer, tmp_path: Path) -> None:
    built = run_of(seconds=0.5, case="fixed")
    csv = converted(app, save(built, tmp_path / "run.h5"), tmp_path / "run.csv")
    again = load(converted(app, csv, tmp_path / "again.h5"))
    assert again.meta == {"case": "fixed"}
    for name in ("plant.theta", "feedback.e", "plant.fault"):
        assert np.array_equal(again[name], built[name])
        assert again.group(name).units == built.group(name).units


def test_log_with_its_own_units_is_in_si_afterwards(app: typer.Typer, tmp_path: Path) -> None:
    """Of one axis, in degrees and mN m; what is written is a log again."""
    t = np.arange(500) * 1e-3
    rows = np.column_stack([3.0 + t, 90.0 * np.sin(9 * t), 250.0 * np.cos(9 * t)])
    head = "time,theta,tau_meas\ns,deg,mN m"
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=head, comments="")
    loaded = load(converted(app, tmp_path / "log.csv", tmp_path / "log.h5"))
    assert np.allclose(loaded["theta"], np.pi / 2 * np.sin(9 * t))
    assert np.allclose(loaded["tau_meas"], 0.25 * np.cos(9 * t))
    assert loaded.group("theta").units["theta"] == "rad"
    again = read_log(converted(app, tmp_path / "log.h5", tmp_path / "si.csv"))
    assert np.allclose(again.theta[:, 0], loaded["theta"])


def test_what_cannot_be_written_is_said_before_reading(app: typer.Typer, tmp_path: Path) -> None:
    run = save(run_of(seconds=0.1), tmp_path / "run.h5")
    for source, target, kind, reason in (
        (tmp_path / "none.h5", tmp_path / "x.doc", UsageError, "unknown ending '.doc'"),
        (tmp_path / "none.h5", tmp_path / "x.csv", LogError, "none.h5: no such file"),
        (run, run, UsageError, "is the run itself"),
    ):
        done = CliRunner().invoke(app, ["convert", str(source), str(target)])
        assert isinstance(done.exception, kind)
        assert reason in str(done.exception)
    assert load(run)["plant.theta"].shape[1] == 6
