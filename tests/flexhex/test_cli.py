"""The command line as a user meets it: one message for a mistake, never a traceback."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

from flexhex import cli
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import parameters
from flexhex.identify.view import fit_json, print_fit
from flexhex.ssp.read import read_ssp
from tests.conftest import MACHINE_FILE


def flexhex(*words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line in a folder of its own."""
    command = [sys.executable, "-m", "flexhex", *map(str, words)]
    env = {"PYTHONPATH": ":".join(sys.path), "PATH": "/usr/bin:/bin", "HOME": str(cwd)}
    env["FLEXHEX_CACHE"] = os.environ["FLEXHEX_CACHE"]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, env=env, check=False)


MISTAKES: dict[str, tuple[list[str], int, str]] = {
    "no such machine": (["run", "-m", "x.toml"], 3, r"x\.toml: no such file"),
    "not a machine": (["build", "-m", "log.csv"], 3, r"log\.csv: not valid TOML"),
    "no such part": (
        ["run", "--only", "fig2"],
        2,
        r"(?s)'fig2' is not one of.*'table'.*'repeatability'.*'missing'",
    ),
    "no truth to vary": (
        ["study", "-m", "other.toml", "--vary", "payload,noise"],
        2,
        r"--vary noise: other\.toml has no truth file other-truth\.toml, .* trajectory can vary",
    ),
    "no such ssp": (["simulate", "x.ssp"], 3, r"x\.ssp: no such file"),
    "not an ssp": (["simulate", "log.csv"], 3, r"log\.csv: not a zip archive"),
    "no such log": (["identify", "x.csv"], 3, r"x\.csv: no such file"),
    "kind of log": (["identify", "run.npx"], 3, r"unknown kind '\.npx'; write CSV or HDF5"),
    "machine as log": (
        ["identify", "other.toml"],
        3,
        r"a machine file is no log: .* as --machine other\.toml",
    ),
    "robot as log": (
        ["identify", "arm.urdf"],
        3,
        r"a robot's file is no log: give it as --base arm\.urdf",
    ),
    "unit of a log": (
        ["identify", "log.csv"],
        3,
        r"theta\[1\] is in 'inc', wanted 'rad' .*: convert",
    ),
    "no such command": (["frobnicate"], 2, r"no such command 'frobnicate'"),
    "truth for a machine": (["build", "-m", "x-truth.toml"], 3, r"x-truth\.toml: a truth file: "),
    "too long for the memory": (
        ["simulate", "loop.ssp", "-d", "1e9"],
        2,
        r"a log of 1e\+09 s takes .* GB of memory, .* GB can be had: run at most .* s",
    ),
    "no file to check": (["check", "x.fmu"], 3, r"x\.fmu: no such file"),
    "nothing to check": (["check", "log.csv"], 3, r"nothing to check in '\.csv', wants \.fmu"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_gives_message_and_exit_code(
    mistake: str,
    hexapod_ssp: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    words, code, message = MISTAKES[mistake]
    (tmp_path / "loop.ssp").symlink_to(hexapod_ssp)
    truth = MACHINE_FILE.with_name("tflex-truth.toml").read_text(encoding="utf-8")
    (tmp_path / "x-truth.toml").write_text(truth, encoding="utf-8")
    (tmp_path / "other.toml").write_text(MACHINE_FILE.read_text(encoding="utf-8"))
    (tmp_path / "log.csv").write_text("time,theta[1],tau_meas[1]\ns,inc,N m\n0,1,2\n1,2,3\n2,3,4\n")
    for name in ("run.npx", "arm.urdf"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["flexhex", *words])
    with pytest.raises(SystemExit) as exit:
        cli.main()
    _, stderr = capsys.readouterr()
    assert exit.value.code == code, stderr
    assert re.search(message, stderr), stderr
    assert "Traceback" not in stderr


def test_mistake_ends_the_process_without_a_traceback(tmp_path: Path) -> None:
    """One mistake as a user makes it; the others are the same function in this process."""
    words, code, message = MISTAKES["no such log"]
    done = flexhex(*words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert re.fullmatch(f"flexhex: {message}.*\n", done.stderr), done.stderr


def test_mistake_is_json_where_that_was_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A program that reads stdout learns there what is wrong."""
    missing = tmp_path / "a.csv"
    words = ["flexhex", "diagnose", str(missing), "--base", "axis", "--json"]
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as exit:
        cli.main()
    stdout, stderr = capsys.readouterr()
    said = json.loads(stdout)
    assert said == {"error": stderr.splitlines()[-1].removeprefix("flexhex: "), "exit": 3}
    assert exit.value.code == 3
    assert str(missing) in said["error"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["diagnose", "a.csv", "--nope"], "no such option: --nope"),
        (["diagnose"], "missing argument 'RUN...'"),
        (["identify", "a.csv", "--settle", "x"], "invalid value for '--settle'"),
        (["nope"], "no such command 'nope'"),
    ],
)
def test_option_that_is_wrong_is_json_where_that_was_asked_for(
    words: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["flexhex", *words, "--json"])
    with pytest.raises(SystemExit) as exit:
        cli.main()
    stdout, stderr = capsys.readouterr()
    said = json.loads(stdout)
    assert (exit.value.code, said["exit"]) == (2, 2)
    assert said["error"].startswith(message)
    assert stderr.splitlines()[0].endswith(f": {said['error']}")


THREADS = """
import os, sys
from flexhex import cli
assert "numpy" not in sys.modules
cli.app = lambda: None
cli.main()
print(os.environ["OPENBLAS_NUM_THREADS"])
"""


@pytest.mark.parametrize(("given", "used"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_linear_algebra_takes_one_thread(given: dict[str, str], used: str, tmp_path: Path) -> None:
    """Set before NumPy is imported, else it has no effect; the user's own value stays."""
    env = {"PYTHONPATH": ":".join(sys.path), "PATH": "/usr/bin:/bin", **given}
    done = subprocess.run(
        [sys.executable, "-c", THREADS],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == [used], done.stderr


def test_version_is_shown(tmp_path: Path) -> None:
    done = flexhex("--version", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"flexhex {metadata.version('flexhex')}\n")


def test_fit_of_mostly_undetermined_parameters_is_warned_of(
    machine: Machine, capsys: pytest.CaptureFixture[str]
) -> None:
    names = tuple(par.name for par in parameters(machine))
    zeros = np.zeros(len(names))
    for loose, warned in ((names[:81], False), (names[:82], True)):
        print_fit(machine, Fit(zeros, zeros, np.zeros(6), 1.0, 10, loose))
        said = " ".join(capsys.readouterr().out.split())
        assert ("82 of 162 parameters are not determined" in said) is warned


def test_what_a_fit_warns_of_is_shown(machine: Machine, capsys: pytest.CaptureFixture[str]) -> None:
    zeros, text = np.zeros(162), "actuator[2].d: negative, though no machine has it so"
    fitted = Fit(zeros, zeros, np.zeros(6), 1.0, 10, (), (text,))
    print_fit(machine, fitted)
    assert f"warning: {text}" in " ".join(capsys.readouterr().out.split())
    assert json.loads(fit_json(machine, fitted))["warnings"] == [text]


def test_check_accepts_what_we_build(fmu_dir: Path, hexapod_ssp: Path, tmp_path: Path) -> None:
    """The .ssp with the FMUs in it, and those that are not."""
    inside = {Path(source).name for source in read_ssp(hexapod_ssp).fmus}
    others = [path for path in fmu_dir.glob("*.fmu") if path.name not in inside]
    done = flexhex("check", hexapod_ssp, *others, MACHINE_FILE, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(others) == 2
    assert done.stdout.count(": ok") == 2 + len(others)


def test_check_complains_about_a_broken_fmu(fmu_dir: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.fmu"
    broken.write_bytes((fmu_dir / "plant.fmu").read_bytes()[:5000])
    done = flexhex("check", broken, cwd=tmp_path)
    assert done.returncode == 1
    assert "broken.fmu: not a zip archive" in done.stdout


def test_simulate_then_identify(machine_ssp: Path, tmp_path: Path) -> None:
    """Seven seconds of the machine are enough for an answer; figures come as JSON."""
    done = flexhex("simulate", machine_ssp, "-d", "7", "-r", "run.h5", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = flexhex("identify", "run.h5", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert len(data["parameters"]) == 162
    assert 0 < np.max(data["residual_rms"]["joints"]) < 0.02
