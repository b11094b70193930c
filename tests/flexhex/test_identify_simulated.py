"""`flexhex identify` shows what positions follow from the torques of held-out runs."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.estimation.forward.record import Model, Simulation
from flexhex.identify.simulated import sentences, simulation_parts, simulation_section
from flexhex.init import two_links as example
from flexhex.output.parts import Sentence, Titled
from tests.diagnosis.estimation.test_identified import arm

BASE = f"{example.__file__}:TwoLinks"
RUN = CliRunner()


def model(error: float, diverged: int = 0, first: float = np.nan) -> Model:
    rms = np.outer(np.linspace(0, 1, 101), [error, 2 * error])
    if diverged:
        rms[round(first / 0.002) :] = np.nan
    return Model(rms, diverged, first, np.zeros((7, 2)))


def told(**changes: object) -> Simulation:
    values = {
        "units": ("rad", "m"), "horizons": (0.05, 0.2), "dt": 0.002, "windows": 8,
        "held_out": True, "constant": model(0.5), "file": model(0.3, 3, 0.15),
        "fitted": model(0.0123), "run": "logs/a.csv", "time": np.arange(7.0),
        "measured": np.zeros((7, 2)),
    }  # fmt: skip
    return Simulation(**{**values, **changes})  # type: ignore[arg-type]


def test_table_has_errors_in_thousandths_after_each_time() -> None:
    table, *rest = simulation_parts(told(), "torque or force")
    assert isinstance(table, Titled)
    assert "from the measured torque or force" in table.title
    assert "RMS of 8 windows of held-out runs" in table.title
    one = {k: table.rows[1][k] for k in ("after", "constant_rate", "file", "fitted", "unit")}
    assert one == {
        "after": "0.2 s", "constant_rate": "500", "file": "–", "fitted": "12.3", "unit": "mrad",
    }  # fmt: skip
    assert table.rows[3]["unit"] == "mm"
    assert table.rows[3]["fitted"] == "24.6"
    assert all(isinstance(part, Sentence) for part in rest)


def test_what_diverged_and_what_is_left_out_is_said() -> None:
    said = " ".join(sentences(told(left_out=("load_friction of axis 1",))))
    assert "With the file's values 3 of 8 windows diverged, the first after 0.15 s" in said
    assert "Not in the simulation: load_friction of axis 1." in said
    assert "estimates" not in said
    without = told(file=None, why="the masses of the file have no forward dynamics: singular")
    table, *_ = simulation_parts(without, "torque")
    assert isinstance(table, Titled)
    assert "file" not in [column.key for column in table.columns]
    assert "The masses of the file have no forward dynamics" in " ".join(sentences(without))


def test_estimates_that_are_worth_nothing_are_said_with_their_axes() -> None:
    short = model(0.5)
    # of the second axis more from the beginning, of the first at the end alone
    worse = replace(short, rms=short.rms * [1.0, 1.2] + np.linspace(-0.1, 0.1, 101)[:, None] ** 3)
    said = " ".join(sentences(told(fitted=worse, horizons=(0.08, 0.2))))
    assert "more than a constant rate after 0.08 s on axis 2, after 0.2 s on axes 1 and 2." in said
    assert "more than a constant rate" not in " ".join(sentences(told()))


def test_plots_are_of_each_unit_for_itself() -> None:
    section = simulation_section(told(), "torque or force", 2)
    assert sorted(section.figures) == [
        "simulated", "simulated-2", "simulated-error", "simulated-error-2",
    ]  # fmt: skip
    drawn = section.figures["simulated-error-2"]
    assert drawn["layout"]["yaxis"]["title"]["text"] == "RMS error [mm]"
    assert {line["name"] for line in drawn["data"]} == {"constant rate", "file", "identified"}
    assert all(line["meta"]["joint"] == 2 for line in drawn["data"])
    (last,) = [line for line in drawn["data"] if line["name"] == "identified"]
    assert last["y"][-1] == pytest.approx(24.6)
    assert last["x"][0] == pytest.approx(0.01)
    (file,) = [line for line in drawn["data"] if line["name"] == "file"]
    assert file["y"][-1] is None


def test_command_shows_it_in_terminal_json_and_page(tmp_path: Path) -> None:
    paths = [str(path) for path in arm(tmp_path, (1, 2, 3))]
    words = ["identify", *paths[:2], "--held-out", paths[2], "--base", BASE]
    done = RUN.invoke(app, [*words, "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert re.search(r"position \(RMS of \d+ windows of held-out runs\)", done.stdout)
    assert "With the file's values" in done.stdout
    data = json.loads((tmp_path / "out" / "identified.json").read_text())["simulation"]
    assert data["units"] == ["rad", "rad"]
    errors = data["position_error_rms"]
    assert errors["fitted"][1][0] < 0.05 * errors["constant_rate"][1][0]
    page = (tmp_path / "out" / "identified.html").read_text()
    assert "Position, simulated from the torque" in page
    assert "arm-3.csv, a held-out run: the positions that follow" in page
    assert "Error of axis {joint} after the start of a window" in page
