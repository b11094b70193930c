"""The sample logs in examples/axis: made by their script, and diagnosed as the guide says."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnose.next import Invocation
from flexhex.diagnose.page import matters, write_diagnosis
from flexhex.diagnosis.logs import read_log
from flexhex.diagnosis.logs.log import Options as LogOptions
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.conftest import ROOT

FOLDER = ROOT / "examples" / "axis"
RUNS = [FOLDER / f"{name}.csv" for name in ("a1", "a2", "b1", "b2")]
HELD_OUT = FOLDER / "c1.csv"


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    """The answer of `flexhex diagnose --base axis a1 a2 b1 b2 --held-out c1`."""
    return diagnose(RUNS, [HELD_OUT], options=Options(base="axis"))


def test_logs_are_what_their_script_writes(tmp_path: Path) -> None:
    """Sines may differ in their last bit between computers, and so a digit of the file."""
    subprocess.run([sys.executable, FOLDER / "make_logs.py", tmp_path], check=True)
    for path in (*RUNS, HELD_OUT):
        ours, written = (read_log(p) for p in (path, tmp_path / path.name))
        for name in ("theta", "tau_meas"):
            assert np.allclose(ours[name].values, written[name].values, atol=6.1e-6), path.name


def test_files_of_the_drive_are_the_same_runs() -> None:
    """Read as the guide says: renamed, in degrees and amperes."""
    options = LogOptions(
        rename={"Position": "theta", "Current": "current"},
        units={"time": "s", "theta": "deg", "current": "A"},
        torque_constant=0.8,
    )
    for path in RUNS:
        ours, drive = read_log(path), read_log(path.with_name(f"drive-{path.name}"), options)
        for name, digit in (("theta", 1e-7), ("tau_meas", 1e-5)):
            assert np.allclose(ours[name].values, drive[name].values, atol=digit), path.name


def test_friction_is_found(diagnosis: Diagnosis) -> None:
    """0.1 N m, as make_logs.py has it."""
    assert diagnosis.verdict == "named"
    (effect,) = diagnosis.effects
    assert (effect.id, effect.rivals) == ("coulomb_friction", ())
    assert effect.parameters["F_c"].value == pytest.approx(0.1, rel=0.03)


def test_torque_over_time_is_that_of_the_held_out_run(diagnosis: Diagnosis) -> None:
    """The measured torque is the log's, smoothed; what the models leave is the residual that the
    answer gives in figures."""
    (strip,) = diagnosis.strips
    assert (Path(strip.run), strip.held_out, strip.axis) == (HELD_OUT, True, 1)
    log = read_log(HELD_OUT)["tau_meas"]
    raw = np.interp(strip.time, log.time, log.values[:, 0])
    # noise of 0.01 N m, and corners of the friction that the window rounds off
    assert np.sqrt(np.mean((strip.measured - raw) ** 2)) < 0.025
    for name in ("before", "after"):
        left = strip.measured - getattr(strip, name)
        rms = float(np.sqrt(np.nanmean(left**2)))
        assert rms == pytest.approx(float(diagnosis.residual.held_out[name][0]), rel=0.02)


def test_page_begins_with_the_torque_over_time(diagnosis: Diagnosis, tmp_path: Path) -> None:
    path = write_diagnosis(
        diagnosis, Invocation(("flexhex",), "axis"), [*RUNS, HELD_OUT], tmp_path / "p"
    )
    text = path.read_text(encoding="utf-8")
    titles = re.findall(r"<h2>(.*?)</h2>", text)
    assert titles[:2] == ["Torque over time", f"Verdict: {diagnosis.verdict}"]
    drawn = re.search(r"^const figures = (.*);$", text, re.M)
    assert drawn
    figures = json.loads(drawn[1])
    assert list(figures)[:2] == ["strip", "strip-residual"]
    assert [line["name"] for line in figures["strip"]["data"]] == [
        "measured",
        "model before",
        "model after",
    ]
    assert figures["strip"]["layout"]["meta"] == {"joint": "axis", "first": 1, "time": "page"}
    assert matters(diagnosis) == 1
