"""What is said of columns that are missing, have other names, or have none: it mends the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import columns, motion, plain_csv, write_csv, write_hdf5


def text_file(path: Path, *lines: str) -> Path:
    path.write_text("\n".join([*lines, "0,1,2", "0.1,2,3", ""]))
    return path


def test_lines_of_uneven_names_and_units_are_told(tmp_path: Path) -> None:
    path = text_file(tmp_path / "a.csv", "# run: 1", "", "time,theta[1],tau_meas[1]", "s,rad")
    with pytest.raises(LogError, match=r"a\.csv: line 3 has 3 names but line 4 has 2 units: give"):
        read_log(path)


@pytest.mark.parametrize("title", ["Robot log exported 2024", "Log", "Robot, cell 4"])
def test_title_above_the_names_is_told(title: str, tmp_path: Path) -> None:
    path = text_file(tmp_path / "a.csv", title, "time,theta[1],tau_meas[1]", "s,rad,N m")
    with pytest.raises(LogError, match=r"a\.csv: line 1 \('.*begin its line with #"):
        read_log(path)


def test_axis_without_a_torque_is_told_with_the_columns_not_used(tmp_path: Path) -> None:
    names, units, values = columns(motion(n=3))
    names[-1] = "third drive"
    path = write_csv(tmp_path / "a.csv", names, units, values)
    with pytest.raises(LogError) as error:
        read_log(path)
    assert str(error.value) == (
        f"{path}: 3 angles but 2 torques: axis 3 has no torque (tau_meas[3]; not used: third drive)"
        ": add a column tau_meas[3], or rename one, --rename 'COLUMN=tau_meas[3]'"
    )
    assert read_log(path, Options(rename={"third drive": "tau_meas[3]"})).tau.shape[1] == 3


def test_channels_of_other_names_are_asked_for_at_once(tmp_path: Path) -> None:
    _, units, values = columns(motion())
    names = ["t", "joint_1", "joint_2", "torque_1", "torque_2"]
    path = write_csv(tmp_path / "a.csv", names, units, values)
    with pytest.raises(LogError) as error:
        read_log(path)
    said = str(error.value)
    assert "no channels theta[1], theta[2] ... and tau_meas[1], tau_meas[2] ... (it has" in said
    assert said.endswith("for instance with --rename joint=theta --rename torque=tau_meas")
    log = read_log(path, Options(rename={"joint": "theta", "torque": "tau_meas"}))
    assert np.array_equal(log.theta, values[:, 1:3])
    with pytest.raises(LogError, match="torque_2; --rename jnt=theta matches none"):
        read_log(path, Options(rename={"jnt": "theta"}))


@pytest.mark.parametrize("write", [plain_csv, write_hdf5])
def test_name_that_no_column_has_is_reported(write: Callable[..., Path], tmp_path: Path) -> None:
    """Beside logs that have it, it is no mistake."""
    path = write(tmp_path / f"a.{'csv' if write is plain_csv else 'h5'}", motion())
    (found,) = read_log(path, Options(rename={"ref": "r"})).findings
    assert found.text.startswith("--rename ref=r matches no column; it has ")
    listed = "theta[1], theta[2], tau_meas[1], tau_meas[2]"
    assert set(listed.split(", ")) <= set(found.text.partition("it has ")[2].split(", "))
    assert read_log(path, Options(rename={"tau_meas": "tau_meas"})).findings == ()
