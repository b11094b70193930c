"""`flexhex view` of measured logs: those that are held out, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import typer
from typer.testing import CliRunner

from flexhex.fmus.common.errors import LogError, UsageError
from tests.conftest import ROOT
from tests.diagnosis.robots.simulated import FILE
from tests.flexhex.robot_logs import AXIS, write
from tests.flexhex.test_view import app, data_of, numbers, shown
from tests.flexhex.test_view_robots import signal

__all__ = ["app"]


def test_held_out_log_is_shown_and_not_fitted(app: typer.Typer, tmp_path: Path) -> None:
    """An offset of its torque is all in its residual, and moves nothing of the other log's."""
    offset = 0.5
    given = np.loadtxt(AXIS / "c1.csv", delimiter=",", skiprows=4)
    log = write(tmp_path / "moved.csv", given[:, 0], given[:, 1:2], given[:, 2:] + offset)
    words = [AXIS / "a1.csv", "--base", "axis", "--held-out"]
    plain, moved = (data_of(shown(app, tmp_path, *words, c)) for c in (AXIS / "c1.csv", log))
    assert [run["name"] for run in moved["runs"]] == ["a1", "moved (held out)"]
    first, second = (
        [numbers(signal(data, "residual", k)["lines"][0]["values"]) for data in (plain, moved)]
        for k in (0, 1)
    )
    assert np.array_equal(*first, equal_nan=True)
    difference = second[1] - second[0]
    assert np.isfinite(difference).sum() > 100
    # torques of float32
    assert np.nanmax(np.abs(difference - offset)) < 1e-6


def test_what_is_not_of_the_base_model_is_refused(app: typer.Typer, tmp_path: Path) -> None:
    one, arm = AXIS / "a1.csv", ROOT / "examples" / "schunk" / "run_001.csv"
    for words, kind, reason in (
        ([arm], LogError, "angles of up to 1.37 rad, the stroke of tflex is 0.524 rad: say whose"),
        ([arm, "--base", "hexapod"], LogError, "the stroke of tflex is 0.524 rad: say whose"),
        ([one, "--held-out", one], UsageError, "--held-out: say whose, --base robot.urdf"),
        ([one, "--base", "axis", "--held-out", one], UsageError, "name it once"),
        ([one], UsageError, "has angles of 1 axis, the machine tflex has 6: .* --base axis"),
        ([one, arm, "--base", "axis"], LogError, "run_001.csv: .*6"),
        ([one, "--base", FILE], UsageError, "6 joints .* the logs have 1 axes"),
        ([one, "--base", "none.urdf"], UsageError, "none.urdf: no such file"),
        ([one, "--base", "nothing"], UsageError, "there are hexapod, axis, a"),
        ([one, "--joints", "j1"], UsageError, "--joints: say whose, --base robot.urdf"),
        ([one, "--tolerance", "mass=1"], UsageError, "--tolerance: say whose"),
        ([one, "--base", "axis", "--machine", "m.toml"], UsageError, "reads no machine file"),
        ([one, "--base", "axis", "--live"], UsageError, "take --base out"),
        ([one, one, "--live"], UsageError, "leave the others out"),
        ([tmp_path / "none.csv", "--base", "axis"], LogError, "no such file"),
    ):
        done = CliRunner().invoke(app, ["view", *map(str, words)])
        assert isinstance(done.exception, kind), done.output
        assert re.search(reason, str(done.exception))
