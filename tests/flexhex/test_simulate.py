"""`flexhex simulate`: file by its ending, figures as `flexhex run` judges them, mistakes."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.fmus.common.errors import FlexhexError
from flexhex.simulate.view import simulation_json, tracking_text
from flexhex.ssp.results import FmuTime, Group, Result, load
from flexhex.tracking import Tracking, tracking

BASE = 0.25e-3


def simulated(error: Any, torque: Any = None) -> Result:
    """A result whose feedback had these errors [rad] and torques [N m], (samples, joints)."""
    signals = {"feedback.e": np.asarray(error)}
    if torque is not None:
        signals["feedback.tau_fb"] = np.asarray(torque)
    times = {"feedback": FmuTime(0.5, 1e-3, 100, 2, "limit reached")}
    seconds = BASE * (len(signals["feedback.e"]) - 1)
    return Result({"0.25ms": Group(1, BASE, signals)}, times, seconds, 0.5)


def spike(joints: int = 3) -> np.ndarray[Any, np.dtype[np.float64]]:
    """4 s: 1 rad until 2 s, then 2 µrad but for -9 µrad of joint 2 at 3 s."""
    e = np.full((16001, joints), 2e-6)
    e[:8001] = 1.0
    e[12000, 1] = -9e-6
    return e


def test_tracking_is_judged_after_the_settling_time() -> None:
    tracked = tracking(simulated(spike(), 1e3 * spike()))
    assert tracked is not None
    assert (tracked.begin, tracked.end, tracked.joint, tracked.at) == (2.0, 4.0, 2, 3.0)
    assert tracked.e_max == pytest.approx(9)
    assert tracked.e == pytest.approx(math.sqrt((4 * (3 * 8000 - 1) + 81) / (3 * 8000)))
    assert tracked.tau_fb == pytest.approx(1e-3 * tracked.e)


def test_tracking_ends_where_it_is_asked_to() -> None:
    tracked = tracking(simulated(spike()), end=2.5)
    assert tracked is not None
    assert (tracked.end, tracked.e_max) == (2.5, pytest.approx(2))
    assert math.isnan(tracked.tau_fb)


def test_short_run_is_judged_whole_and_says_so() -> None:
    tracked = tracking(simulated(spike()[:4001]))
    assert tracked is not None
    assert (tracked.begin, tracked.end, tracked.e) == (0.0, 1.0, pytest.approx(1e6))
    assert "the run ends before 2 s" in tracking_text(tracked)
    assert "τ_FB" not in tracking_text(tracked)


def test_text_has_units() -> None:
    text = tracking_text(Tracking(2.0, 4.0, 23.04, 185.0, 4, 3.5, 0.0044))
    assert "RMS 23.04 µrad, largest 185 µrad (joint 4 at 3.5000 s)" in text
    assert "RMS 0.0044 N m" in text


def test_system_without_feedback_has_no_tracking() -> None:
    other = Result({"1ms": Group(4, BASE, {"a.y": np.zeros(5)})}, {}, 1.0, 1.0)
    assert tracking(other) is None
    assert json.loads(simulation_json(other, Path("r.h5")))["tracking"] is None


def test_json_holds_no_nan() -> None:
    e = spike()
    e[9000] = np.nan
    data = json.loads(simulation_json(simulated(e), Path("r.h5")))
    assert data["tracking"]["e_rms_urad"] is None
    assert data["fmus"]["feedback"]["warnings"] == 2


def test_simulation_is_saved_as_csv_and_printed_as_json(
    machine_ssp: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["simulate", str(machine_ssp), "-d", "2.2", "-r", "new/run.csv", "--also", "K.p"]
    done = CliRunner().invoke(app, [*words, "--json"])
    assert done.exit_code == 0
    data, result = json.loads(done.stdout), load(tmp_path / "new" / "run.csv")
    assert data["result"] == str(Path("new/run.csv"))
    e = result["feedback.e"][result.time("feedback.e") > 2]
    assert len(e) == 800
    assert data["tracking"]["e_rms_urad"] == pytest.approx(1e6 * np.sqrt(np.mean(e**2)))
    assert 0 < data["tracking"]["e_max_urad"] < 1e3
    assert result["K.p"].shape == (74, 162)
    assert data["fmus"]["plant"]["steps"] == 8800
    shown = CliRunner().invoke(app, words).stdout
    places = [shown.index(text) for text in ("Tracking", "Time in each FMU", "result   new/run")]
    assert places == sorted(places)


MISTAKES = {
    "missing file": (["none.ssp"], 3, "none.ssp: no such file"),
    "folder": (["folder"], 3, "folder: is a folder: name a file in it"),
    "no archive": (["file"], 3, "file: not a zip archive.*: copy or build it anew"),
    "negative duration": (["loop.ssp", "-d", "-1"], 2, "duration -1 s: must be .* above 0"),
    "no duration": (["loop.ssp", "-d", "0"], 2, "duration 0 s: must be .* above 0"),
    "nan duration": (["loop.ssp", "-d", "nan"], 2, "duration nan s: must be a finite time"),
    "half a step": (["loop.ssp", "-d", "0.0001"], 2, "0.4 base steps of 0.00025 s"),
    "signal": (["loop.ssp", "--also", "plant.teta"], 2, "did you mean 'theta'"),
    "component": (["loop.ssp", "--also", "plnt.theta"], 2, "did you mean 'plant'"),
    "ending": (["none.ssp", "-r", "r.xlsx"], 2, "unknown ending '.xlsx': .* .h5, .*.csv"),
    "target is a folder": (["none.ssp", "-r", "folder"], 3, "folder: is a folder: name a file"),
    "below a file": (["none.ssp", "-r", "file/r.h5"], 3, "file is a file, not a folder"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_line_and_leaves_nothing(
    mistake: str, machine_ssp: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wrong targets are refused before the system is read: there is no none.ssp."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("x")
    (tmp_path / "loop.ssp").symlink_to(machine_ssp)
    words, code, message = MISTAKES[mistake]
    error = CliRunner().invoke(app, ["simulate", *words]).exception
    assert isinstance(error, FlexhexError)
    assert error.exit_code == code
    with pytest.raises(FlexhexError, match=message):
        raise error
    assert "\n" not in str(error)
    names = {path.name for path in tmp_path.iterdir()} - {"out"}
    assert names == {"folder", "file", "loop.ssp"}, "out: the compiled executor"


def test_parameters_of_the_command_line_are_set_and_kept(hexapod_ssp: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.h5"
    amplitude = "reference.amplitude=0.1,0.2,0.1,0.2,0.1,0.2"
    words = ["simulate", str(hexapod_ssp), "-d", "0.01", "-r", str(result)]
    done = CliRunner().invoke(app, [*words, "-p", "reference.kind=chirp", "-p", amplitude])
    assert done.exit_code == 0, done.output
    meta = load(result).meta
    assert meta["parameter reference.kind"] == 3
    assert meta["parameter reference.amplitude[2]"] == 0.2


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["-p", "reference.kind"], "must be NAME=VALUE"),
        (["-p", "=3"], "must be NAME=VALUE"),
        (["-p", "reference.seed=3", "-p", "reference.seed=4"], "has a value already"),
        (["-p", "reference.kind=chrip"], "did you mean 'chirp'"),
    ],
)
def test_parameter_of_the_command_line_is_refused_in_words(
    hexapod_ssp: Path, tmp_path: Path, words: list[str], text: str
) -> None:
    result = str(tmp_path / "result.h5")
    done = CliRunner().invoke(app, ["simulate", str(hexapod_ssp), "-r", result, *words])
    assert isinstance(done.exception, FlexhexError)
    assert text in str(done.exception)
