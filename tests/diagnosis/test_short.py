"""A run that is too short is refused for that, before anything else is said of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.runs.span import refuse_short
from flexhex.diagnosis.workflow import diagnose
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import columns, motion, plain_csv, write_csv

AXIS = Options("axis")
ROBOT = """<robot name="r"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/></joint>
</robot>"""


def test_length_is_judged_before_the_pairing(tmp_path: Path) -> None:
    """Of so few samples a turned sign would be named, whatever they are."""
    file = tmp_path / "arm.urdf"
    file.write_text(ROBOT)
    t = np.arange(40) * 0.01
    q = 0.5 * np.sin(9 * t)[:, None]
    run = {"time": t, "theta": q, "tau_meas": -0.18 * -81 * q - 2 * 9.81 * 0.2 * np.cos(q)}
    path = plain_csv(tmp_path / "short.csv", run)
    with pytest.raises(LogError) as error:
        diagnose([path], options=Options(str(file)))
    assert str(error.value).startswith(f"{path}: 0.4 s are too short: smoothing takes 0.36 s at")
    assert str(error.value).endswith("at least 1 s are needed: is the unit of its times right?")


def test_time_in_another_unit_is_no_lack_of_motion(tmp_path: Path) -> None:
    """Rates of some hundreds of rad/s look like noise."""
    names, units, values = columns(motion(9.0, n=1, ts=0.01))
    path = write_csv(tmp_path / "ms.csv", names, ["ms", *units[1:]], values)
    with pytest.raises(LogError, match=r"ms\.csv: 0\.009 s are too short.*unit of its times right"):
        identify([path], options=AXIS)


def test_settling_is_named_where_it_was_given(tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion(4.0, n=1))
    with pytest.raises(LogError) as error:
        identify([path], options=AXIS, settle=3.9)
    said = str(error.value)
    assert ": 4 s are too short: the first 3.9 s (--settle 3.9) are left out, smoothing" in said
    assert said.endswith("s are needed"), "4 s are long enough: their unit is not doubted"
    # of the base model's own there is no option
    short = plain_csv(tmp_path / "b.csv", motion(0.4, n=1))
    with pytest.raises(LogError, match=r"the first 0\.2 s are left out, smoothing"):
        identify([short], options=AXIS)
    assert run_set_of([short], (), None, AXIS, settle=0.0)[0].settle == 0.0


def test_passes_that_share_too_little_are_named_with_their_lengths(tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion(4.0, n=1))
    base, run_set, _ = run_set_of([path], (), None, AXIS)
    (run,) = run_set.runs
    passes = [run, replace(run, name="b.csv", shift=-3.7)]
    with pytest.raises(LogError) as error:
        refuse_short(base, passes)
    said = str(error.value)
    assert said.startswith(f"{path} (4 s) and b.csv (4 s), passes of one motion, share too little")
    assert "s remain in common; at least 0.312 s are needed" in said


def test_bound_of_noise_is_said(tmp_path: Path) -> None:
    run = motion(4.0, n=1)
    noise = 0.02 * np.random.default_rng(3).standard_normal(run["theta"].shape)
    path = plain_csv(tmp_path / "a.csv", {**run, "theta": noise})
    _, _, trouble = run_set_of([path], (), None, AXIS)
    assert trouble.startswith("no axis moves by more than 0.")
    assert " rad, less than 50 times the noise of its angles (0.0" in trouble
    still = plain_csv(tmp_path / "b.csv", {**run, "theta": 0.1 + 0 * noise})
    assert run_set_of([still], (), None, AXIS)[2] == (
        "no axis moves by more than 0 rad: a run must excite the machine"
    )
