"""What a user reads after a common mistake: what is there, what is wanted, what to type."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.check import fmu as check_fmu
from flexhex.check.files import check_file
from flexhex.cli import app
from flexhex.diagnose.options import writable
from flexhex.diagnosis.estimation.identify import fit
from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import FlexhexError, InterfaceError, LogError, OutputError
from flexhex.fmus.common.machine.machine import Machine
from tests.conftest import ROOT

ROWS = [f"{0.001 * k},{0.01 * k},{k % 7}" for k in range(3000)]


def log_file(folder: Path, *header: str) -> Path:
    """A CSV log of one axis at 1 kHz under a header of one or two rows."""
    path = folder / "a.csv"
    path.write_text("\n".join([*header, *ROWS]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "words",
    [
        *("run -m no.toml", "build -m no.toml", "study -m no.toml", "check no.toml"),
        *("simulate no.ssp", "export no.ssp --variables", "check no.fmu", "check --results no.fmu"),
        *("identify no.csv", "diagnose no.csv", "compare no.csv no.h5", "report no.csv"),
        *("identify good.csv -m no.toml", "diagnose good.csv -m no.toml"),
    ],
)
def test_missing_file_has_the_same_words_everywhere(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log_file(tmp_path, "time,theta[1],tau_meas[1]", "s,rad,N m").rename(tmp_path / "good.csv")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, words.split())
    assert isinstance(done.exception, FlexhexError), done.exception
    assert done.exception.exit_code == 3
    assert re.match(r"no\.\w+: no such file", str(done.exception)), done.exception


def test_column_is_renamed_by_its_whole_header(tmp_path: Path) -> None:
    path = log_file(tmp_path, "Time [s],Position [deg],Drive torque (N m)")
    names = {
        "Time [s]": "time",
        "Position [deg]": "theta[1]",
        "Drive torque (N m)": "tau_meas[1]",
    }
    log = read_log(path, Options(rename=names))
    assert log.theta[100, 0] == pytest.approx(3.14159265 / 180)
    plain = {"Time": "time", "Position": "theta[1]", "Drive torque": "tau_meas[1]"}
    assert (read_log(path, Options(rename=plain)).theta == log.theta).all()


def test_columns_of_the_file_are_named_where_channels_are_missing(tmp_path: Path) -> None:
    path = log_file(tmp_path, "time [s],Position [deg],Drive torque (N m)")
    with pytest.raises(LogError) as caught:
        read_log(path)
    text = str(caught.value)
    assert "no channels theta[1]" in text
    assert "Position, Drive torque" in text
    assert "--rename 'COLUMN=theta[1]'" in text


@pytest.mark.parametrize(
    ("header", "text"),
    [
        (
            "time [s],theta[1] [mm],tau_meas[1] [N m]",
            r"tau_meas\[1\] is in 'N m', but theta\[1\] .* linear axis, which wants 'N' here",
        ),
        (
            "time [s],theta[1] [rad],tau_meas[1] [N]",
            r"tau_meas\[1\] is in 'N', but theta\[1\] .* rotary axis, which wants 'N m' here",
        ),
    ],
)
def test_force_beside_an_angle_is_refused_with_what_is_wanted(
    header: str, text: str, tmp_path: Path
) -> None:
    with pytest.raises(LogError, match=text):
        read_log(log_file(tmp_path, header))


def test_log_of_a_slide_is_no_log_of_the_hexapod(machine: Machine, tmp_path: Path) -> None:
    log = read_log(log_file(tmp_path, "time [s],theta[1] [mm],tau_meas[1] [N]"))
    text = r"axis 1 is linear \(position in m, force in N\), that of tflex is rotary: .*--base axis"
    with pytest.raises(LogError, match=text):
        fit(machine, [log])


def test_log_of_one_axis_is_sent_to_its_base(machine: Machine, tmp_path: Path) -> None:
    log = read_log(log_file(tmp_path, "time [s],theta[1] [mrad],tau_meas[1] [N m]"))
    with pytest.raises(LogError, match=r"1 axis, tflex has 6: .*--base axis"):
        fit(machine, [log])


def test_page_in_a_folder_that_takes_no_file_is_bad_input(tmp_path: Path) -> None:
    """Exit code 3, as of every command; root may write everywhere, but not below a file."""
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"--out .*: cannot be written") as caught:
        writable("--out", tmp_path / "file" / "page.html")
    assert caught.value.exit_code == 3


def test_file_to_check_that_is_none_is_bad_input(tmp_path: Path) -> None:
    for path, text in ((tmp_path / "x.fmu", "no such file"), (tmp_path, "is a folder")):
        with pytest.raises(InterfaceError, match=text):
            check_file(path)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (AttributeError("'NoneType' object has no attribute 'startswith'"), "is missing"),
        (RuntimeError("generator raised StopIteration"), "is missing"),
        (KeyError("furlong"), "it refers to 'furlong', which it does not declare"),
        (Exception("ScalarVariable 3 has no name"), "ScalarVariable 3 has no name"),
    ],
)
def test_where_fmpy_stumbles_the_description_is_blamed(
    error: Exception, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stumbles(path: str, **_: bool) -> None:
        raise error

    monkeypatch.setattr("fmpy.model_description.read_model_description", stumbles)
    (said,) = check_fmu._fmpy(Path("x.fmu"), False)
    assert said.endswith((text, f"{text} ({type(error).__name__})"))
    assert not re.search("NoneType|generator", said)


def test_example_of_a_single_fmu_wants_only_the_fmu() -> None:
    command = [sys.executable, str(ROOT / "examples" / "single_fmu.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.strip().endswith("the following arguments are required: fmu")
