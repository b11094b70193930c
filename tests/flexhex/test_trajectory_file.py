"""Trajectory files: what is read, and one clear line for each mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.errors import TrajectoryError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.trajectory.file import read_rows
from flexhex.trajectory.limits import CHUNK
from flexhex.trajectory.motion import read_motion
from tests.compare import assert_close

NAMES = ",".join(["time", *(f"r[{k}]" for k in range(1, 7))])
UNITS = "s" + ",rad" * 6
POSE = "time,x_E.x,x_E.y,x_E.z,phi_E.x,phi_E.y,phi_E.z"
POSE_UNITS = "s,mm,mm,mm,deg,deg,deg"


def joints(*values: float, step: float = 0.5) -> list[str]:
    """Rows in which joint 1 goes through values, from and to zero."""
    path = [0.0, *values, 0.0]
    return [f"{k * step},{value}" + ",0" * 5 for k, value in enumerate(path)]


def written(folder: Path, *lines: str) -> Path:
    path = folder / "motion.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_units_separators_and_comments_are_understood(tmp_path: Path) -> None:
    names, units = NAMES.replace(",", ";"), "ms" + ";deg" * 6
    lines = ["# name: mine", names, units, "0" + ";0" * 6, "# halfway", "", "500;9" + ";0" * 5]
    rows = read_rows(written(tmp_path, *lines))
    assert rows.kind == "joints"
    assert list(rows.lines) == [4, 7]
    assert_close(rows.time, [0, 0.5], atol=1e-15)
    assert_close(rows.of["r"][0][1], [np.pi / 20, 0, 0, 0, 0, 0], atol=1e-15)
    assert not rows.payload.any()


def test_accelerations_may_be_in_degrees_with_any_spelling(tmp_path: Path) -> None:
    order = [f"{name}[{k}]" for name in ("r", "rd", "rdd") for k in range(1, 7)]
    units = ["s", *["deg"] * 6, *["deg/s"] * 6, *["deg/s^2"] * 3, *["deg/s²"] * 3]
    lines = [",".join(["time", *order]), ",".join(units), "0" + ",0" * 18, "1" + ",180" * 18]
    rows = read_rows(written(tmp_path, *lines))
    for part in rows.of["r"]:
        assert_close(part[1], np.full(6, np.pi), atol=1e-15)


@pytest.mark.parametrize("turn", ["phi", "lam"])
def test_rotation_vectors_and_quaternions_are_the_same_motion(
    tmp_path: Path, machine: Machine, turn: str
) -> None:
    """A turn about z by a quintic, with rates; -lam is as good as lam."""
    time = np.linspace(0, 1, 21)
    s = np.poly1d([6, -15, 10, 0, 0, 0])
    angle = [0.2 * p(time) for p in (s, s.deriv(), s.deriv(2))]
    if turn == "phi":
        parts = [np.column_stack([0 * a, 0 * a, a]) for a in angle]
        units = ["rad", "rad/s", "rad/s2"]
    else:
        a, ad, add = angle
        half = np.column_stack([np.cos(a / 2), 0 * a, 0 * a, np.sin(a / 2)])
        across = np.column_stack([-np.sin(a / 2), 0 * a, 0 * a, np.cos(a / 2)])
        second = add[:, None] / 2 * across - (ad[:, None] / 2) ** 2 * half
        parts = [half, ad[:, None] / 2 * across, second]
        parts = [part * np.where(np.arange(21) % 2, -1, 1)[:, None] for part in parts]
        units = ["1", "1/s", "1/s2"]
    names, unit_row, columns = ["time"], ["s"], [time[:, None]]
    for order, (d, part) in enumerate(zip(("", "d", "dd"), parts, strict=True)):
        elements = [".x", ".y", ".z"] if turn == "phi" else [f"[{k}]" for k in range(1, 5)]
        names += [f"x{d}_E.{axis}" for axis in "xyz"]
        names += [f"{turn}{d}_E{element}" for element in elements]
        unit_row += [["m", "m/s", "m/s2"][order]] * 3 + [units[order]] * part.shape[1]
        at = (0.0, 0.0, 0.3) if order == 0 else (0.0,) * 3
        columns += [np.tile(at, (21, 1)), part]
    body = [",".join(map(repr, row)) for row in np.hstack(columns).tolist()]
    path = written(tmp_path, ",".join(names), ",".join(unit_row), *body)
    rows = read_motion(path, machine).rows
    half = np.column_stack([np.cos(angle[0] / 2), np.sin(angle[0] / 2)])
    assert_close(rows[:, [3, 6]], half, atol=1e-15)
    # lam'' along lam is -|lam'|^2
    assert_close(np.sum(rows[:, 3:7] * rows[:, 10:14], axis=1), np.zeros(21), atol=1e-15)
    size = np.sum(rows[:, 10:14] ** 2, axis=1)
    assert_close(np.sum(rows[:, 3:7] * rows[:, 17:21], axis=1), -size, atol=1e-14)
    assert_close(np.sqrt(size), np.abs(angle[1]) / 2, atol=1e-15)


MISTAKES = {
    "no file": (None, r"motion.csv: no such file"),
    "no number": (
        [NAMES, UNITS, *joints("abc")],
        r"motion.csv: line 4: r\[1\] is 'abc', no finite number",
    ),
    "NaN": ([NAMES, UNITS, *joints("nan")], r"line 4: r\[1\] is 'nan', no finite number"),
    "infinite": ([NAMES, UNITS, *joints("inf")], r"line 4: r\[1\] is 'inf', no finite number"),
    "short row": ([NAMES, UNITS, "0,0"], r"line 3: 2 fields, 7 names in the first row"),
    "one row": ([NAMES, UNITS, "0" + ",0" * 6], r"1 rows of numbers: a motion has at least two"),
    "no units": ([NAMES, *joints(0.1)], r"0 units for 7 names: the second row gives the unit"),
    "unit": (
        [NAMES, UNITS.replace("rad", "m", 1), *joints(0.1)],
        r"column r\[1\]: unit 'm', must be one of rad, mrad",
    ),
    "no unit": ([NAMES, UNITS.replace("rad", "", 1), *joints(0.1)], r"column r\[1\]: unit ''"),
    "time stands": (
        [NAMES, UNITS, *joints(0.1, step=0.0)],
        r"line 4 \(t = 0 s\): time must rise, the row before is at 0 s",
    ),
    "no time": (
        [NAMES.replace("time", "payload"), UNITS.replace("s,", "kg,", 1), *joints(0.1)],
        r"has no column time",
    ),
    "unknown column": (
        [NAMES.replace("r[2]", "tau[2]"), UNITS, *joints(0.1)],
        r"unknown column 'tau\[2\]': a trajectory has time, payload",
    ),
    "seventh joint": ([NAMES + ",r[7]", UNITS + ",rad"], r"unknown column 'r\[7\]'"),
    "missing joint": (
        [NAMES.replace(",r[2]", ""), UNITS.removesuffix(",rad"), "0" + ",0" * 5, "1" + ",0" * 5],
        r"column r\[2\] is missing",
    ),
    "twice": ([NAMES.replace("r[2]", "r[1]"), UNITS, *joints(0.1)], r"column r\[1\] stands twice"),
    "both kinds": (
        [NAMES + POSE.removeprefix("time"), UNITS + POSE_UNITS[1:], "0" + ",0" * 12],
        r"has columns of r and x and phi: must be",
    ),
    "position alone": (
        [POSE.partition(",phi")[0], "s,m,m,m", "0,0,0,0.3", "1,0,0,0.3"],
        r"has columns of x: must be .*zeros where the platform stays level",
    ),
    "rates of one": (
        [POSE + ",xd_E.x,xd_E.y,xd_E.z", POSE_UNITS + ",m/s,m/s,m/s", "0" + ",0" * 9],
        r"has no phid_E, which goes with the other rates",
    ),
    "accelerations alone": (
        [NAMES + NAMES.removeprefix("time").replace("r", "rdd"), UNITS + ",rad/s2" * 6],
        r"has no rd, which goes with the other rates",
    ),
    "payload": (
        [NAMES + ",payload", UNITS + ",kg", *(line + ",-1" for line in joints(0.1))],
        r"line 3 \(t = 0 s\): payload -1 kg, allowed 0 to 50 kg",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_in_a_file_is_one_clear_line(tmp_path: Path, name: str) -> None:
    lines, message = MISTAKES[name]
    path = tmp_path / "motion.csv" if lines is None else written(tmp_path, *lines)
    with pytest.raises(TrajectoryError, match=message) as error:
        read_rows(path)
    assert "\n" not in str(error.value)


IMPOSSIBLE = {
    "start": (
        [NAMES, UNITS, *joints(0.1)[1:]],
        r"line 3 \(t = 0.5 s\): the motion starts with a jump: r\[1\] is 0.1 from the neutral pose",
    ),
    "start of a pose": (
        [POSE, POSE_UNITS, "0,0,0,310,0,0,0", "1,0,0,300,0,0,0"],
        r"line 3 \(t = 0 s\): the motion starts with a jump: x_E\.z is 0.01 from the neutral",
    ),
    "tilted start": (
        [POSE, POSE_UNITS, "0,0,0,300,1,0,0", "1,0,0,300,0,0,0"],
        r"the motion starts with a jump: orientation is 0.00873 from the neutral pose",
    ),
    "moving end": (
        [
            NAMES + NAMES.removeprefix("time").replace("r", "rd"),
            UNITS + ",rad/s" * 6,
            "0" + ",0" * 12,
            "1" + ",0" * 8 + ",0.2" + ",0" * 3,
        ],
        r"line 4 \(t = 1 s\): the motion ends with a jump: the rate of r\[3\] is not zero",
    ),
    "stroke": (
        [NAMES, UNITS, *joints(0.6)],
        r"lines 3 to 4, t = 0.3\d* s: joint 1 leaves its stroke: 0.52\d* rad, allowed -0.52",
    ),
    "jump": (
        [NAMES, UNITS, *joints(0.1, step=0.01)],
        r"lines 3 to 4, t = 0.00\d* s: a jump, or too fast: joint 1 accelerates by .* its motor",
    ),
    "swing": (
        [NAMES, UNITS, *(f"{t},{v}" + ",0" * 5 for t, v in ((0, 0), (5, 0), (6, 0.1), (7, 0.1)))],
        r"lines 3 to 4, t = 2.5 s: r\[1\] swings by 0.0\d* beyond its rows: .* add rows, or",
    ),
    "jump between ticks": (
        [
            ",".join([NAMES, *(f"{d}[{k}]" for d in ("rd", "rdd") for k in range(1, 7))]),
            UNITS + ",rad/s" * 6 + ",rad/s2" * 6,
            *(f"{t},{value}" + ",0" * 17 for t, value in (("0", 0), ("0.50001", 0))),
            *(f"{t},{value}" + ",0" * 17 for t, value in (("0.50002", 0.1), ("1", 0))),
        ],
        r"lines \d to \d, t = 0.5\d* s: a jump, or too fast: joint 1 accelerates by",
    ),
    "out of reach": (
        [POSE, POSE_UNITS, "0,0,0,300,0,0,0", "9,0,0,900,0,0,0", "18,0,0,300,0,0,0"],
        r"lines 3 to 4, t = \d\.\d* s: the pose is out of reach of arm",
    ),
    "no pose": (
        [NAMES, UNITS, "0" + ",0" * 6, "1,0.2,0.4,0.5,-0.4,-0.1,0.4", "2" + ",0" * 6],
        r"lines 3 to 4, t = 0\.\d* s: no pose of the end-effector has these six angles",
    ),
    "quaternion": (
        [
            "time,x_E.x,x_E.y,x_E.z,lam_E[1],lam_E[2],lam_E[3],lam_E[4]",
            "s,m,m,m,1,1,1,1",
            "0,0,0,0.3,1,0,0,0",
            "1,0,0,0.3,0,0,0,0",
        ],
        r"line 4 \(t = 1 s\): lam_E has the length 0, must be 1",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_the_machine_cannot_do_is_refused_with_line_and_time(
    tmp_path: Path, machine: Machine, name: str
) -> None:
    lines, message = IMPOSSIBLE[name]
    with pytest.raises(TrajectoryError, match=message) as error:
        read_motion(written(tmp_path, *lines), machine)
    assert "\n" not in str(error.value)


def test_payload_and_times_count_from_the_first_row(tmp_path: Path, machine: Machine) -> None:
    lines = [line + f",{k}" for k, line in enumerate(joints(0.1))]
    moved = [f"{float(line.partition(',')[0]) + 7},{line.partition(',')[2]}" for line in lines]
    table = read_motion(written(tmp_path, NAMES + ",payload", UNITS + ",kg", *moved), machine)
    assert_close(table.time, [0, 0.5, 1], atol=1e-15)
    assert_close(table.payload, [0, 1, 2])


def test_a_long_motion_may_be_fast_at_any_time(tmp_path: Path, machine: Machine) -> None:
    """Over 50 s, which are looked at in parts: 0.9 rad/s where two of them meet."""
    time = np.linspace(0, 50, 501)
    values = 0.3 * np.sin(np.pi * time) * np.sin(np.pi * time / 50) ** 2
    rows = [",".join(map(str, [t, *[value] * 6])) for t, value in zip(time, values, strict=True)]
    table = read_motion(written(tmp_path, NAMES, UNITS, *rows), machine)
    assert CHUNK * machine.timing.base == 25
    assert table.end == 50
