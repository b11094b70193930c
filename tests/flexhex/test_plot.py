"""`flexhex plot`: small curves, figures and the page."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.plot.command import plot_command
from flexhex.plot.draw import LEVELS, Picked, curve, drawn, scaled
from flexhex.ssp.results import save
from tests.flexhex.test_view import run_of


@pytest.fixture
def app() -> typer.Typer:
    application = typer.Typer()
    application.command("plot")(plot_command)
    application.callback()(lambda: None)
    return application


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


def test_curve_shows_that_a_signal_swings() -> None:
    """Ten waves in each of its stretches, whose means are all alike; then none."""
    swing = np.sin(2 * np.pi * np.arange(4000.0) / 100)
    marks = curve(np.append(swing, np.zeros(1000)), 5)
    assert set(marks[:4]) <= {LEVELS[0], LEVELS[-1]}
    assert marks[4] in LEVELS[3:5]


def test_table_has_the_figures_of_each_scalar(app: typer.Typer, run: Path, tmp_path: Path) -> None:
    page = tmp_path / "plot.html"
    words = ["plot", str(run), "plant.theta[2]", "feedback.e", "--from", "2", "--page", str(page)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    rows = {line.split()[0]: line.split() for line in done.stdout.splitlines() if "[" in line}
    assert list(rows) == ["plant.theta[2]", *(f"feedback.e[{k}]" for k in range(1, 7))]
    built = run_of()
    kept = built.time("plant.theta") >= 2.0
    theta = built["plant.theta"][kept, 1]
    figures = [float(text) for text in rows["plant.theta[2]"][2:5]]
    wanted = [1e3 * v for v in (theta.min(), theta.max(), np.sqrt(np.mean(theta**2)))]
    assert rows["plant.theta[2]"][5] == "mrad"
    assert {rows[f"feedback.e[{k}]"][5] for k in range(1, 7)} == {"µrad"}
    assert figures == pytest.approx(wanted, rel=1e-3)
    text = page.read_text(encoding="utf-8")
    figures = json.loads(re.search(r"^const figures = (.*);$", text, re.M)[1])  # type: ignore[index]
    assert [len(one["data"]) for one in figures.values()] == [1, 6]
    assert figures["signal0"]["data"][0]["x"][0] == 2.0
    assert figures["signal1"]["layout"]["yaxis"]["title"]["text"] == "feedback.e [µrad]"
    panels = figures["signal1"]["layout"]["meta"]["multiples"]
    assert panels == {"names": [f"joint {k} [µrad]" for k in range(1, 7)], "same": True}
    assert [line["yaxis"] for line in figures["signal1"]["data"]] == [
        "y",
        *(f"y{k}" for k in range(2, 7)),
    ]
    e = built["feedback.e"][kept, 3] * 1e6
    assert max(figures["signal1"]["data"][3]["y"]) == pytest.approx(e.max(), rel=1e-4)


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


def test_value_has_the_prefix_that_fits_the_largest() -> None:
    for most, unit, wanted in (
        (23e-6, "rad", "µrad"),
        (0.5, "N m", "mN m"),
        (1e-3, "rad", "mrad"),
        (2e-3, "rad", "mrad"),
        (3e-12, "m", "nm"),
        (1.0, "rad", "rad"),
        (0.01, "1", "1"),
        (0.0, "rad", "rad"),
    ):
        values, named = scaled(np.array([0.0, -most, np.nan]), unit)
        assert named == wanted
        size = {"µrad": 1e-6, "mrad": 1e-3, "mN m": 1e-3, "nm": 1e-9}.get(wanted, 1.0)
        assert values[1] == pytest.approx(-most / size)


def test_lines_of_other_units_or_sizes_have_scales_of_their_own() -> None:
    def panels(sizes: tuple[float, ...], units: tuple[str, ...]) -> Any:
        t = np.linspace(0.0, 1.0, 50)
        values = np.sin(9 * t)[:, None] * np.array(sizes)
        names = tuple(f"tau[{i}]" for i in range(1, len(sizes) + 1))
        return drawn(Picked("tau", t, values, names, units))["layout"]["meta"]["multiples"]

    assert panels((3.0, 1.0), ("N m", "N m"))["same"] is True
    assert panels((30.0, 1.0), ("N m", "N m"))["same"] is False
    assert panels((3.0, 1.0), ("N m", "N")) == {
        "names": ["joint 1 [N m]", "joint 2 [mN]"],
        "same": None,
    }
