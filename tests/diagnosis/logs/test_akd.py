"""What the recorder of an AKD drive gives out, and CSV with the names of its parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

T = np.arange(800) * 62.5e-6 * 8
ANGLE, RATE, CURRENT = 12.0 * np.sin(9 * T), 18.0 * np.cos(9 * T), 1.5 * np.sign(np.cos(9 * T))
"""[deg], [rpm], [A]"""
COLUMNS = {"IL.FB": CURRENT, "PL.FB": ANGLE, "VL.FB": RATE, "PL.CMD": ANGLE + 0.5}
UNITS = {"theta": "deg", "thetad": "rpm", "r": "deg"}
KNOWN = Options(0.8, UNITS)


def internal(value: float) -> str:
    """As the drive writes numbers that computers are to read."""
    whole = round(abs(value) * 1000)
    return f"F3{'-' if value < 0 else ''}0x{whole:X}"


def recorded(path: Path, head: str = "800,8", fast: bool = False, names: str = "") -> Path:
    lines = [head, names or ",".join(COLUMNS)]
    form = internal if fast else "{:.3f}".format
    lines += [",".join(map(form, row)) for row in zip(*COLUMNS.values(), strict=True)]
    path.write_text("\r\n".join([*lines, "-->", ""]))
    return path


@pytest.mark.parametrize("fast", [False, True], ids=["standard", "internal"])
@pytest.mark.parametrize("head", ["800,8", "8,800"])
def test_recorder_counts_its_times_and_is_read_by_the_names_of_the_drive(
    head: str, fast: bool, tmp_path: Path
) -> None:
    log = read_log(recorded(tmp_path / "a.csv", head, fast), KNOWN)
    # three digits after the point in the units of the drive
    assert_close(log.ts, 5e-4, rtol=1e-12)
    assert_close(log.theta[:, 0], np.deg2rad(ANGLE), atol=np.deg2rad(5.01e-4))
    assert_close(log["thetad"].values[:, 0], RATE * np.pi / 30, atol=np.pi / 30 * 5.01e-4)
    assert_close(log["r"].values[:, 0], np.deg2rad(ANGLE + 0.5), atol=np.deg2rad(5.01e-4))
    assert_close(log.tau[:, 0], 0.8 * CURRENT, atol=0.8 * 5.01e-4)
    assert any("800 of 800 points, 0.5 ms apart" in str(f) for f in log.findings)


def test_recorder_stopped_early_says_how_much_it_holds(tmp_path: Path) -> None:
    log = read_log(recorded(tmp_path / "a.csv", "10000,16"), KNOWN)
    assert_close(log.ts, 1e-3, rtol=1e-12)
    assert any("800 of 10000 points" in str(f) for f in log.findings)


def test_constant_and_unit_are_asked_for_at_once(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"--torque-constant.*; theta has no unit.*--unit theta=rad"):
        read_log(recorded(tmp_path / "a.csv"))


@pytest.mark.parametrize(("line", "said"), [
    ("0.1,0.2", "line 803 has 2 numbers, wanted 4"),
    ("0.1,0.2,F3,0.1", "line 803: 'F3' is no number"),
])  # fmt: skip
def test_broken_line_is_named(line: str, said: str, tmp_path: Path) -> None:
    path = recorded(tmp_path / "a.csv")
    path.write_text(path.read_text().replace("-->", line))
    with pytest.raises(LogError, match=said):
        read_log(path, KNOWN)


def test_recorder_without_samples_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1000,16\nIL.FB,PL.FB\n")
    with pytest.raises(LogError, match="recorder of the drive holds none"):
        read_log(path, KNOWN)


def test_numbers_in_the_first_line_alone_are_no_recorder(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1000,16\ntime,theta\n0,1\n")
    with pytest.raises(LogError, match="no row of names"):
        read_log(path, KNOWN)


@pytest.mark.parametrize(("unit", "size"), [("Arms", 1.0), ("mA", 1e3)])
def test_table_with_the_names_of_the_drive_is_read_with_the_units_of_its_head(
    unit: str, size: float, tmp_path: Path
) -> None:
    names = f"Time (ms),IL.FB ({unit}),PL.FB (deg),VL.FB (rpm)"
    rows = np.column_stack([1e3 * T, size * CURRENT, ANGLE, RATE])
    np.savetxt(tmp_path / "s.csv", rows, delimiter=",", header=names, comments="", fmt="%.9g")
    log = read_log(tmp_path / "s.csv", Options(0.8))
    assert_close(log.theta[:, 0], np.deg2rad(ANGLE), atol=1e-9)
    assert_close(log["thetad"].values[:, 0], RATE * np.pi / 30, atol=1e-8)
    assert_close(log.tau[:, 0], 0.8 * CURRENT, atol=1e-9)


def test_count_of_an_encoder_is_a_part_of_a_turn(tmp_path: Path) -> None:
    counts = np.round(ANGLE / 360 * 65536)
    rows = np.column_stack([T, CURRENT, counts])
    head = "time,current,theta\ns,A,counts"
    np.savetxt(tmp_path / "c.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")
    with pytest.raises(LogError, match="each is rev/65536"):
        read_log(tmp_path / "c.csv", Options(0.8))
    log = read_log(tmp_path / "c.csv", Options(0.8, {"theta": "rev/65536"}))
    assert_close(log.theta[:, 0], 2 * np.pi * counts / 65536, rtol=1e-12)
