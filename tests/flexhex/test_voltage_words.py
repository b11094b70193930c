"""Logs in volts in the terminal, on pages and in files: absolute with `--motor`, else nowhere."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from tests.diagnosis.motors import F_C, GEAR, J, K, L, R, write

ABSOLUTE = re.compile(r"\bN m\b|\bkg m|torque (?:RMS|about)")
RUN = CliRunner()
MOTOR = f"R={R} K_t={K} L={1e3 * L} mH gear={GEAR:g}"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    return [str(path) for path in write(tmp_path_factory.mktemp("runs"))]


def test_identify_writes_volts_alone_and_says_so_once(runs: list[str], tmp_path: Path) -> None:
    csv, fmu = tmp_path / "found.csv", tmp_path / "found.fmu"
    words = ["identify", *runs[:4], "--held-out", runs[4], "--base", "axis", "--all"]
    done = RUN.invoke(app, [*words, "--write", str(csv), "--fmu", str(fmu)])
    assert done.exit_code == 0, done.output
    assert done.stdout.count("all results are relative, in volts") == 1
    assert "V s²/rad" in done.stdout
    assert "voltage RMS" in done.stdout
    described = zipfile.ZipFile(fmu).read("modelDescription.xml").decode()
    assert '<Unit name="V s2/rad">' in described
    for text in (done.stdout, csv.read_text(), re.sub(r"<(?!Unit ).*?>", "", described)):
        assert not ABSOLUTE.search(text), ABSOLUTE.search(text)


def test_identify_with_the_motor_is_absolute(runs: list[str], tmp_path: Path) -> None:
    path = tmp_path / "found.csv"
    words = ["identify", *runs[:4], "--base", "axis", "--motor", MOTOR, "--write", str(path)]
    done = RUN.invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "motor data R=1.2 K_t=0.05 K_e=0.05 L=0.0036 gear=20" in done.stdout
    assert "relative" not in done.stdout
    rows = {row.split(",")[0]: row.split(",") for row in path.read_text().splitlines()}
    assert rows["F_c[1]"][1] == "N m"
    assert float(rows["F_c[1]"][2]) == pytest.approx(F_C, rel=0.05)
    assert rows["J[1]"][1] == "kg m2"
    assert float(rows["J[1]"][2]) == pytest.approx(J, rel=0.03)  # beside cogging


def test_diagnosis_and_its_page_are_in_volts(runs: list[str], tmp_path: Path) -> None:
    words = ["diagnose", *runs[:4], "--base", "axis", "--out", str(tmp_path)]
    done = RUN.invoke(app, words)
    assert done.exit_code == 1, done.output
    page = (tmp_path / "diagnosis.html").read_text()
    for text in (done.stdout, (tmp_path / "diagnosis.json").read_text(), page):
        assert "relative, in volts" in text
        assert "back-EMF" in text
        assert not ABSOLUTE.search(text), ABSOLUTE.search(text)


def test_view_shows_volts(runs: list[str], tmp_path: Path) -> None:
    page = tmp_path / "view.html"
    done = RUN.invoke(app, ["view", *runs[:2], "--base", "axis", "--page", str(page)])
    assert done.exit_code == 0, done.output
    assert '"units":["V"]' in page.read_text()
    assert '"units":["N m"]' not in page.read_text()


def test_motor_beside_a_torque_constant_is_a_wrong_option(runs: list[str]) -> None:
    words = ["diagnose", *runs[:2], "--base", "axis", "--torque-constant", "3", "--motor", MOTOR]
    done = RUN.invoke(app, words)
    assert "--motor: not beside --torque-constant" in str(done.exception)
