"""`flexhex report`: figures of a recording, and files that are none."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.fmus.common.errors import LogError
from flexhex.recording import Recording, read_recording
from flexhex.report.recorded import changes, drive_state, errors, missed, quantiles, slower

CHANNELS = ("theta", "tau_meas", "e", "statusword", "error_code", "al_state")
PLAIN = (
    "phase",
    "answered",
    "working_counter",
    "late_threads",
    "wake_up",
    "round_trip",
    "compute",
)
ENABLED, FAULT, OP = 0x0637, 0x0238, 8


def recorded(cycles: int = 20, lost: int = 3, left_out: int = 5) -> Recording:
    """A run in which a reply was lost, a cycle was left out and drive 2 has a fault at the end."""
    names = [f"{name}[{axis}]" for name in CHANNELS for axis in range(1, 7)]
    names = ["time", *names, *PLAIN]
    rows = np.zeros((cycles, len(names)))
    recording = Recording(
        tuple(names), ("1",) * len(names), rows, {"base_step_s": "0.25", "signals": "-"}
    )
    n = np.arange(float(cycles))
    rows[:, 0] = 0.25 * (n + (n >= left_out))
    for name, value in (("statusword", ENABLED), ("al_state", OP)):
        rows[:, recording.places(name)] = value
    for name, column in (("phase", 1), ("answered", 1), ("working_counter", 18), ("compute", n)):
        rows[:, recording.places(name)[0]] = column
    rows[lost, recording.places("answered")] = 0
    rows[lost, recording.places("theta")] = np.nan
    rows[:, recording.places("e")] = 1e-6 * np.outer(n, np.arange(1, 7))
    rows[-1, recording.places("statusword")[1]] = FAULT
    rows[-1, recording.places("error_code")[1]] = 0x7305
    return recording


def write(recording: Recording, file: Path) -> Path:
    """The recording as the gateway writes it."""
    head = [f"# {key}: {value}" for key, value in recording.meta.items()]
    lines = [",".join(recording.names), ",".join(recording.units)]
    rows = [",".join("NaN" if np.isnan(v) else f"{v:.17g}" for v in row) for row in recording.rows]
    file.write_text("\n".join([*head, *lines, *rows]) + "\n")
    return file


def test_what_was_missed_is_counted() -> None:
    gaps = missed(recorded())
    assert (gaps.left_out, gaps.unanswered, gaps.short) == (1, 1, 0)
    recording = recorded()
    recording.rows[7, recording.places("working_counter")] = 15
    assert missed(recording).short == 1


def test_errors_are_judged_after_the_hold() -> None:
    """Settled after 2 s: cycles 8 to 19 (one was left out), axis k has k µrad a cycle."""
    listed = errors(recorded())
    n = np.arange(8.0, 20.0)
    for axis, (rms, most, at) in enumerate(listed, start=1):
        assert rms == pytest.approx(axis * np.sqrt(np.mean(n**2)), rel=1e-9)
        assert (most, at) == (pytest.approx(axis * 19.0, rel=1e-9), 5.0)


def test_states_that_changed_are_reported_with_their_axes() -> None:
    listed = changes(recorded())
    assert listed[:3] == [(0.0, "all", text) for text in ("OP", "no fault", "operation enabled")]
    assert listed[3:] == [(5.0, "2", "fault"), (5.0, "2", "fault 0x7305")]
    assert drive_state(0x0250) == "switch on disabled"
    assert drive_state(0x0231) == "ready to switch on"


def test_times_are_quantiles_of_their_cycles() -> None:
    assert quantiles(recorded())["compute"] == pytest.approx((9.5, 18.81, 18.981, 19.0))
    time, share = slower(np.array([3.0, 1.0, 2.0, 0.0]))
    assert time.tolist() == [1, 2, 3]
    assert share == pytest.approx([1, 2 / 3, 1 / 3])


def test_command_tells_and_draws(tmp_path: Path) -> None:
    file = write(recorded(), tmp_path / "run.csv")
    page = tmp_path / "run.html"
    done = CliRunner().invoke(app, ["report", str(file), "--page", str(page)])
    assert done.exit_code == 0, done.output
    assert "without a trip" in done.output
    assert re.search(r"largest +at *\n.*µrad +s", done.output)
    assert "operation enabled" in page.read_text()
    # a panel for each axis, which one selector chooses
    match = re.search(r"const figures = (\{.*?\});\n", page.read_text())
    assert match
    for name in ("error", "theta", "tau_meas"):
        drawn = json.loads(match[1])[name]
        assert [line["meta"] for line in drawn["data"]] == [
            {"panel": k, "joint": k + 1} for k in range(6)
        ]
        assert drawn["layout"]["meta"]["joint"] == "axis"
    done = CliRunner().invoke(app, ["report", str(file), "--page", str(page), "--json"])
    assert json.loads(done.output)["missed"]["left_out"] == 1


def test_file_of_another_kind_says_what_shows_it(tmp_path: Path) -> None:
    for name, content in (("run.h5", b"\x89HDF\r\n\xff"), ("log.csv", b"time,theta\ns,rad\n0,1\n")):
        (tmp_path / name).write_bytes(content)
        done = CliRunner().invoke(app, ["report", str(tmp_path / name)])
        assert isinstance(done.exception, LogError)
        assert "no recording of the gateway" in str(done.exception)
        assert "`flexhex view` and `flexhex plot` show results" in str(done.exception)


def test_file_of_a_trip_is_reported_too(tmp_path: Path) -> None:
    """Only the reaction: no cycle of the controller is in it."""
    recording = recorded()
    recording.rows[:, recording.places("phase")] = 2
    recording.meta["trip"] = "jump: axis 2: angle jumped"
    file = write(recording, tmp_path / "run-trip.csv")
    done = CliRunner().invoke(app, ["report", str(file), "--page", str(tmp_path / "a.html")])
    assert done.exit_code == 0, done.output
    assert "tripped: jump: axis 2: angle jumped" in done.output


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [("# base_step_s: 0.25", "# base_step_s: 0", "damaged"), (",phase,", ",phases,", "damaged")],
)
def test_damaged_recording_is_refused(old: str, new: str, wanted: str, tmp_path: Path) -> None:
    file = write(recorded(), tmp_path / "run.csv")
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(LogError, match=wanted):
        read_recording(file)


def test_recording_without_a_channel_is_refused_by_its_name(tmp_path: Path) -> None:
    file = write(recorded(), tmp_path / "run.csv")
    file.write_text(file.read_text().replace(",answered,", ",asked,"))
    done = CliRunner().invoke(app, ["report", str(file), "--page", str(tmp_path / "a.html")])
    assert isinstance(done.exception, LogError)
    assert "run.csv: a recording without answered: record" in str(done.exception)
    assert not (tmp_path / "a.html").exists()
