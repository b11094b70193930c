"""`flexhex drive`: the loop on emulated drives, and what it says where that cannot be."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from flexhex import drive_cable
from flexhex.drive import error, recorded, steps
from flexhex.drive_cable import PATIENT, PROGRAM, check_means, drive
from flexhex.drive_view import drive_command
from fmus.common.errors import LogError, RunError, UsageError
from ssp.results import Group, Result
from tests.gateway.cargo import built

COLUMNS = ("theta", "tau_meas", "r", "tau", "e")


def recording(path: Path, cycles: list[int], phases: list[int]) -> Path:
    """A recording whose every signal is the number of its cycle plus a tenth of its axis."""
    names = ["time", *(f"{c}[{k}]" for c in COLUMNS for k in range(1, 7)), "cycle", "phase"]
    lines = ["# run: gateway", ",".join(names), ",".join("1" for _ in names)]
    for n, phase in zip(cycles, phases, strict=True):
        values = [n + k / 10 for _ in COLUMNS for k in range(1, 7)]
        lines.append(",".join(map(repr, [n * 0.00025, *values, n, phase])))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_recording_becomes_a_result_of_the_cycles_that_ran(tmp_path: Path) -> None:
    path = recording(tmp_path / "a.csv", [0, 1, 2, 3, 4], [1, 1, 1, 1, 2])
    result = recorded(path)
    assert np.array_equal(result["plant.theta"][:, 2], [0.3, 1.3, 2.3, 3.3])
    assert result.group("feedback.e").base == 0.00025
    assert result.duration == pytest.approx(3 * 0.00025, rel=1e-12)


def test_a_cycle_that_was_left_out_repeats_the_one_before(tmp_path: Path) -> None:
    path = recording(tmp_path / "a.csv", [0, 1, 4, 5], [1, 1, 1, 1])
    assert np.array_equal(recorded(path)["reference.r"][:, 0], [0.1, 1.1, 1.1, 1.1, 4.1, 5.1])


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "b.csv"
    other.write_text("time,theta[1]\ns,rad\n0,0\n")
    with pytest.raises(LogError, match="no recording"):
        recorded(other)
    with pytest.raises(RunError, match="the controller never ran"):
        recorded(recording(tmp_path / "c.csv", [0, 1], [0, 0]))


def test_errors_are_judged_after_the_hold(tmp_path: Path) -> None:
    """From 2 s on, n = 8001 and 8002: the RMS of n + k / 10 over six axes."""
    result = recorded(recording(tmp_path / "a.csv", list(range(8003)), [1] * 8003))
    judged = np.add.outer([8001.0, 8002.0], np.arange(1, 7) / 10)
    rms, most = error(result)
    assert rms == pytest.approx(1e6 * np.sqrt(np.mean(judged**2)), rel=1e-12)
    assert most == pytest.approx(1e6 * judged.max(), rel=1e-12)
    assert all(np.isnan(error(Result(result.groups | short(result)))))


def short(result: Result) -> dict[str, Group]:
    """The same group, over before the hold is."""
    (name, group), *_ = result.groups.items()
    signals = {key: values[:100] for key, values in group.signals.items()}
    return {name: Group(group.period, group.base, signals)}


def test_steps_are_those_of_the_configured_drive() -> None:
    """Exactly: 1 mA at 3 N m/A and 2^32 counts, as the drives' integers stand for."""
    tau = 3.0 * 0.001
    theta = 6.283185307179586 / 4294967296
    wanted = {"plant.tau_step": tau, "feedback.tau_step": tau, "plant.theta_step": theta}
    assert steps() == wanted


def test_every_patient_limit_is_in_the_configuration(tmp_path: Path) -> None:
    text = drive_cable._patient(tmp_path / "a.toml").read_text()
    for key, value in PATIENT.items():
        assert text.count(f"\n{key} = {value}") == 1, key


def test_without_program_or_root_it_is_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(drive_cable, "PROGRAM", tmp_path / "none")
    with pytest.raises(UsageError, match="make gateway"):
        check_means()
    monkeypatch.setattr(drive_cable, "PROGRAM", Path(__file__))
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(UsageError, match="run this as root"):
        drive_command(out=tmp_path)


@pytest.fixture(scope="module")
def program() -> Path:
    """The gateway, where a cable can be made for it."""
    if shutil.which("ip") is None or os.geteuid() != 0:
        pytest.skip("network namespaces need root and `ip`")
    return built("flexhex-gateway") / PROGRAM.name


def test_a_drive_leaves_a_recording_and_no_namespace(
    program: Path, hexapod_ssp: Path, tmp_path: Path
) -> None:
    driven = drive(hexapod_ssp, 0.1, tmp_path / "a.csv", True)
    assert driven.trip == ""
    assert driven.summary["cycles"] == 400
    assert recorded(driven.recording)["plant.theta"].shape == (400, 6)
    left = [n["name"] for n in json.loads(namespaces() or "[]")]
    assert not [name for name in left if name.startswith("flexhex-") and str(os.getpid()) in name]


def namespaces() -> str:
    """All named network namespaces as JSON."""
    done = subprocess.run(["ip", "-j", "netns", "list"], capture_output=True, text=True)
    return done.stdout


def test_a_refusal_of_either_side_is_an_error(
    program: Path, hexapod_ssp: Path, tmp_path: Path
) -> None:
    with pytest.raises(RunError, match=r"flexhex-gateway emulate: .*none\.ssp"):
        drive(tmp_path / "none.ssp", 0.1, tmp_path / "a.csv", True)
