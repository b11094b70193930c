"""`flexhex plot`: small curves, figures and the page."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.plot.command import plot_command
from flexhex.plot.draw import LEVELS, curve
from flexhex.ssp.results import save
from tests.flexhex.test_view import run_of


@pytest.fixture
def app() -> typer.Typer:
    made = typer.Typer()
    made.command("plot")(plot_command)
    made.callback()(lambda: None)
    return made


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return save(run_of(), tmp_path / "run.h5")


def test_curve_rises_with_its_samples() -> None:
    assert curve(np.arange(80.0), 8) == LEVELS
    assert curve(np.arange(-8.0, 0.0), 40) == LEVELS, "no more marks than samples"
    assert curve(np.zeros(9), 3) == LEVELS[0] * 3
    holed = np.arange(80.0)
    holed[10:20] = np.nan
    assert curve(holed, 8) == LEVELS[0] + " " + LEVELS[2:]
    assert curve(np.full(4, np.nan), 2) == "  "


def test_table_has_the_figures_of_each_scalar(app: typer.Typer, run: Path, tmp_path: Path) -> None:
    page = tmp_path / "plot.html"
    words = ["plot", str(run), "plant.theta[2]", "feedback.e", "--from", "2", "--page", str(page)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    rows = {line.split()[0]: line.split() for line in done.stdout.splitlines() if "[" in line}
    assert list(rows) == ["plant.theta[2]", *(f"feedback.e[{k}]" for k in range(1, 7))]
    made = run_of()
    kept = made.time("plant.theta") >= 2.0
    theta = made["plant.theta"][kept, 1]
    figures = [float(text) for text in rows["plant.theta[2]"][2:5]]
    wanted = [theta.min(), theta.max(), np.sqrt(np.mean(theta**2))]
    assert figures == pytest.approx(wanted, rel=1e-3)
    text = page.read_text(encoding="utf-8")
    drawn = json.loads(re.search(r"^const figures = (.*);$", text, re.M)[1])  # type: ignore[index]
    assert [len(one["data"]) for one in drawn.values()] == [1, 6]
    assert drawn["signal0"]["data"][0]["x"][0] == 2.0
    assert drawn["signal1"]["layout"]["yaxis"]["title"]["text"] == "rad"


def test_without_signals_they_are_listed(app: typer.Typer, run: Path) -> None:
    done = CliRunner().invoke(app, ["plot", str(run)])
    assert re.search(r"plant\.theta +6 × rad", done.stdout)
    assert re.search(r"plant\.fault", done.stdout)


def test_unknown_signals_and_times_are_refused(app: typer.Typer, run: Path) -> None:
    for words, kind, reason in (
        (["plant.thta"], LogError, "did you mean 'plant.theta'"),
        (["plant.theta", "--from", "9"], UsageError, "plant.theta lasts from 0 to 4 s"),
    ):
        done = CliRunner().invoke(app, ["plot", str(run), *words])
        assert isinstance(done.exception, kind)
        assert reason in str(done.exception)
