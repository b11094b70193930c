"""Timetables and other objects of MATLAB's are refused with the lines that save them as numbers."""

from __future__ import annotations

import struct
from pathlib import Path

import h5py
import numpy as np
import pytest

from flexhex.diagnosis.logs import read_log
from flexhex.fmus.common.errors import LogError

UNITS = (("run/theta_unit", "rad"), ("run/tau_meas_unit", "N m"), ("run/time_unit", "s"))
LINES = {
    "timetable": "time = seconds(TT.Properties.RowTimes); theta = TT.theta;",
    "table": "time = TT.time; theta = TT.theta;",
    "timeseries": "time = TT.Time; theta = TT.Data;",
    "datetime": "save run time theta tau_meas unit",
}


def _element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def version5(path: Path, kind: str) -> Path:
    """An object in a MAT v5 file: flags, name, storage, class, and numbers that nobody explains."""
    texts = b"".join(_element(1, text) for text in (b"TT", b"MCOS", kind.encode()))
    flags = _element(6, struct.pack("<II", 17, 0))
    matrix = _element(14, flags + texts + _element(6, b"\0" * 24))
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + matrix)
    return path


def version73(path: Path, kind: str, beside: bool = False) -> Path:
    """The same in a v7.3 file."""
    with h5py.File(path, "w") as file:
        dataset = file.create_dataset("TT", data=np.zeros((1, 6), dtype=np.uint32))
        dataset.attrs["MATLAB_class"], dataset.attrs["MATLAB_object_decode"] = np.bytes_(kind), 3
        if beside:
            for name in ("run/time", "run/theta", "run/tau_meas"):
                file[name] = np.linspace(0, 1, 200)[None, :]
            for name, unit in UNITS:
                text = file.create_dataset(name, data=[[ord(c)] for c in unit], dtype=np.uint16)
                text.attrs["MATLAB_class"] = np.bytes_("char")
    return path


@pytest.mark.parametrize("kind", LINES)
@pytest.mark.parametrize("write", [version5, version73])
def test_an_object_is_refused_with_the_lines_that_save_it(
    tmp_path: Path, write: object, kind: str
) -> None:
    path = write(tmp_path / "run.mat", kind)  # type: ignore[operator]
    with pytest.raises(LogError) as said:
        read_log(path)
    assert f"TT is a {kind}, which MATLAB alone can read" in str(said.value)
    assert LINES[kind] in str(said.value)


def test_numbers_beside_an_object_are_read(tmp_path: Path) -> None:
    log = read_log(version73(tmp_path / "run.mat", "datetime", beside=True))
    assert log["theta"].values.shape == (200, 1)
