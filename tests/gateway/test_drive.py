"""`flexhex drive`: the loop on emulated drives, and what it says where that cannot be."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import time
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from flexhex.diagnosis.result.verdict import Diagnosis, Residual
from flexhex.drive import cable, runs, view
from flexhex.drive.cable import PATIENT, PROGRAM, Driven, check_means, drive
from flexhex.drive.command import drive_command
from flexhex.drive.runs import error, steps
from flexhex.fmus.common.errors import RunError, UsageError
from flexhex.recording import load_recording
from flexhex.ssp.results import Group, Result
from studies.quantisation import torque_step, variants
from tests.gateway.cargo import built


def moved(n: int) -> Result:
    """Errors n + k / 10 of axis k at base step n."""
    e = np.add.outer(np.arange(float(n)), np.arange(1, 7) / 10)
    return Result({"0.25ms": Group(1, 0.00025, {"feedback.e": e})})


def test_errors_are_judged_after_the_hold() -> None:
    """From 2 s on, n = 8001 and 8002: the RMS over two samples of six axes."""
    judged = np.add.outer([8001.0, 8002.0], np.arange(1, 7) / 10)
    rms, most = error(moved(8003))
    assert rms == pytest.approx(1e6 * np.sqrt(np.mean(judged**2)), rel=1e-12)
    assert most == pytest.approx(1e6 * judged.max(), rel=1e-12)
    assert np.isnan(error(moved(8000))).all()


def test_steps_are_those_of_the_configured_drive() -> None:
    """Exactly: 1 mA at 3 N m/A and 2^32 counts, as the drives' integers stand for."""
    tau = 3.0 * 0.001
    theta = 6.283185307179586 / 4294967296
    wanted = {"plant.tau_step": tau, "feedback.tau_step": tau, "plant.theta_step": theta}
    assert steps() == wanted
    carried = variants()[2]
    assert carried.parameters() == wanted, "the benchmark of the steps asks for the same"
    assert torque_step("cia402") == 9.0 * 0.001


@pytest.mark.parametrize(("known", "wanted"), [({"seed": None}, {"seed": 2.0}), ({}, {})])
def test_second_pass_has_noise_of_its_own(
    known: dict[str, None], wanted: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the plant has noise; the first pass keeps the simulation's."""
    plant = SimpleNamespace(fmu=SimpleNamespace(variables=known))
    monkeypatch.setattr(runs, "read_ssp", lambda _: SimpleNamespace(instance=lambda _: plant))
    assert runs.other_noise(Path("a.ssp"), 2) == wanted
    assert runs.other_noise(Path("a.ssp"), 1) == {}


def test_passes_that_cannot_be_diagnosed_are_no_error(tmp_path: Path) -> None:
    why = runs.diagnosed([tmp_path / "none.csv"], tmp_path / "m")
    assert isinstance(why, str)
    assert "none.csv: no such file" in why
    assert view.diagnosed(why).startswith("not possible: ")
    alone = Residual(("N m",) * 6, *(np.full(6, np.nan) for _ in range(7)), {})
    diagnosis = Diagnosis("changed", (), (), alone)
    assert view.diagnosed(diagnosis) == "no verdict: the two passes do not repeat each other."
    diagnosis = Diagnosis("cannot tell", (), (), alone, notes=("too short",))
    assert view.diagnosed(diagnosis).endswith("Too short.")


def test_options_of_the_plant_are_taken_by_the_emulator(tmp_path: Path) -> None:
    text = cable._options(tmp_path / "a.toml", {"seed": 2.0, "f": 3.5}).read_text()
    assert tomllib.loads(text)["plant"]["parameters"] == {"plant.seed": 2.0, "plant.f": 3.5}
    assert tomllib.loads(cable._options(tmp_path / "b.toml", {}).read_text()) == {
        "plant": {"parameters": {}}
    }


def test_every_patient_limit_is_in_the_configuration(tmp_path: Path) -> None:
    text = cable._patient(tmp_path / "a.toml").read_text()
    for key, value in PATIENT.items():
        assert text.count(f"\n{key} = {value}") == 1, key


def test_relaxed_limits_are_reported_with_what_was_seen(tmp_path: Path) -> None:
    """A pass that lost two and three replies in a row, and one that lost none."""
    head = "# base_step_s: 0.00025\n# signals: theta=plant.theta:1\ntime,phase,answered\ns,1,1\n"
    driven = {}
    for name, lost in (("clock-1", {3, 4, 7, 8, 9}), ("clock-2", set[int]())):
        # before the run nothing is judged
        rows = [f"{k},{0 if k < 2 else 1},{int(k > 2 and k not in lost)}" for k in range(12)]
        rows[2] = "2,1,1"
        file = tmp_path / f"{name}.csv"
        file.write_text(head + "\n".join(rows) + "\n")
        late = {"p50": 1.0, "max": 30.0 + len(lost)}
        summary = {"wake_up_us": late, "share_of_limits": {"jump": 0.01, "torque_step": 0.02}}
        driven[name] = Driven(summary, "", file)
    rows_of = {row["limit"]: row for row in runs.relaxed(driven)}
    assert set(rows_of) == set(PATIENT)
    overrun = rows_of["overrun_us"]
    assert (overrun["configured"], overrun["here"], overrun["seen"]) == ("2000", "1000000", 35.0)
    assert rows_of["lost_frame_limit"]["seen"] == 3
    assert rows_of["jump_rad"]["seen"] == pytest.approx(0.0005)
    assert rows_of["torque_step_N_m"]["seen"] == pytest.approx(1.0)
    assert rows_of["watchdog_ms"]["seen"] is None


def test_without_program_or_root_it_is_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(cable, "PROGRAM", tmp_path / "none")
    with pytest.raises(UsageError, match="make gateway"):
        check_means()
    monkeypatch.setattr(cable, "PROGRAM", Path(__file__))
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(UsageError, match="run this as root"):
        drive_command(out=tmp_path)


@pytest.fixture(scope="module")
def program() -> Path:
    """The gateway, where a cable can be made for it."""
    if shutil.which("ip") is None or os.geteuid() != 0:
        pytest.skip("network namespaces need root and `ip`")
    return built() / PROGRAM.name


def test_a_drive_leaves_a_recording_and_no_namespace(
    program: Path, hexapod_ssp: Path, tmp_path: Path
) -> None:
    driven = drive(hexapod_ssp, 0.1, tmp_path / "a.csv", True)
    assert driven.trip == ""
    assert driven.summary["cycles"] == 400
    assert load_recording(driven.recording)["plant.theta"].shape == (400, 6)
    left = [n["name"] for n in json.loads(namespaces() or "[]")]
    assert not [name for name in left if name.startswith("flexhex-") and str(os.getpid()) in name]


def test_what_a_killed_run_left_is_removed_and_no_other(program: Path) -> None:
    """A child makes namespaces and is killed; what is still running inside goes too."""
    over = subprocess.Popen(["true"])
    over.wait()
    dead, ours = f"flexhex-drives-{over.pid}", f"flexhex-gateway-{os.getpid()}"
    other = f"flexhex-else-{over.pid}"
    for name in (dead, ours, other):
        subprocess.run(["ip", "netns", "add", name], check=True)
    inside = subprocess.Popen(["ip", "netns", "exec", dead, "sleep", "60"])
    try:
        while "sleep" not in Path(f"/proc/{inside.pid}/comm").read_text():
            time.sleep(0.01)
        cable._remove_left_behind()
        left = [n["name"] for n in json.loads(namespaces())]
        assert dead not in left
        assert {ours, other} <= set(left)
        assert inside.wait(timeout=20) == -signal.SIGKILL
    finally:
        inside.kill()
        for name in (dead, ours, other):
            subprocess.run(["ip", "netns", "del", name], capture_output=True)


def namespaces() -> str:
    """All named network namespaces as JSON."""
    done = subprocess.run(["ip", "-j", "netns", "list"], capture_output=True, text=True)
    return done.stdout


def test_a_refusal_of_either_side_is_an_error(
    program: Path, hexapod_ssp: Path, tmp_path: Path
) -> None:
    with pytest.raises(RunError, match=r"flexhex-gateway emulate: .*none\.ssp"):
        drive(tmp_path / "none.ssp", 0.1, tmp_path / "a.csv", True)
