"""Recordings of the gateway as results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.errors import LogError
from flexhex.recording import load_recording

GOOD = """# base_step_s: 0.00025
# signals: theta=plant.theta:1 tau_ff=F.tau_ff:2 fault=W.fault:2
time,theta[1],theta[2],tau_ff[1],tau_ff[2],fault,phase
s,rad,rad,N m,N m,1,1
0,1,2,3,4,0,1
0.00025,5,6,3,4,0,1
0.0005,7,8,9,10,1,1
0.00075,9,9,9,10,1,2
# trip: asked
"""


def recording(folder: Path, text: str) -> Path:
    """The text as a file."""
    file = folder / "run.csv"
    file.write_text(text)
    return file


def test_recording_gives_the_signals_at_their_rates(tmp_path: Path) -> None:
    result = load_recording(recording(tmp_path, GOOD))
    assert result["plant.theta"].tolist() == [[1, 2], [5, 6], [7, 8]]
    assert result["F.tau_ff"].tolist() == [[3, 4], [9, 10]]
    assert result["W.fault"].tolist() == [0, 1]
    assert np.array_equal(result.time("F.tau_ff"), [0, 0.0005])
    assert list(result.groups) == ["0.25ms", "0.5ms"]
    assert result.group("plant.theta").units["plant.theta"] == "rad"


def test_what_a_lost_reply_did_not_measure_is_a_straight_line(tmp_path: Path) -> None:
    text = GOOD.replace("0.00025,5,6,", "0.00025,NaN,NaN,")
    result = load_recording(recording(tmp_path, text))
    assert result["plant.theta"].tolist() == [[1, 2], [4, 5], [7, 8]]


def test_what_the_clock_left_out_keeps_its_place(tmp_path: Path) -> None:
    """0.0005 is left out: what follows stays at its time, and so do the rates."""
    text = GOOD.replace("0.0005,7,8,9,10,1,1", "0.00075,7,8,9,10,1,1").replace(
        "0.00075,9,9,9,10,1,2", "0.001,9,9,11,12,1,1"
    )
    result = load_recording(recording(tmp_path, text))
    assert result["plant.theta"].tolist() == [[1, 2], [5, 6], [6, 7], [7, 8], [9, 9]]
    assert result["F.tau_ff"].tolist() == [[3, 4], [6, 7], [11, 12]]


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("# signals", "# channels", "no recording of the gateway"),
        ("theta=plant.theta:1", "thetas=plant.theta:1", "damaged"),
        (":1 tau_ff", ":x tau_ff", "damaged"),
        ("0,1,2,3,4,0,1", "0,1,2", "damaged"),
    ],
)
def test_file_that_is_no_recording_is_refused(
    old: str, new: str, wanted: str, tmp_path: Path
) -> None:
    with pytest.raises(LogError, match=wanted):
        load_recording(recording(tmp_path, GOOD.replace(old, new)))
    with pytest.raises(LogError, match=r"none\.csv: no such file"):
        load_recording(tmp_path / "none.csv")
