"""Logs of the generator: what its logger does to the signals, and what it writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from studies.generator.logger import logged
from studies.generator.trajectories import RATE
from studies.generator.write import write
from tests.compare import assert_close
from tests.oracles.calculus import Array
from tests.studies.test_generator import FIRST, runs


def test_logger_delays_both_torques_alike() -> None:
    """Half a sample of hold and the delay, read off the slope; steps of 3 mN m set the bound."""
    case, clean = runs("")
    case = replace(case, noise=replace(case.noise, white=0.0), log=replace(case.log, delay=1.7))
    for name, signal in (("tau_meas", clean.i), ("tau", clean.tau)):
        shown = logged(case, clean)[0].channels[name].T
        late = signal[:, 0, FIRST:] - shown
        slope = np.gradient(signal[:, 0], 1 / RATE, axis=-1)[:, FIRST:]
        delay = np.sum(late * slope) / np.sum(slope**2)
        assert delay == pytest.approx(2.2 / RATE, rel=0.1), name
    angles = logged(case, clean)[0].channels["theta"].T
    assert_close(angles, clean.q[:, 0, FIRST:], atol=0.51e-8)


def test_dropped_samples_leave_gaps_in_time() -> None:
    case, clean = runs("")
    case = replace(case, log=replace(case.log, dropped=0.01))
    time = logged(case, clean)[0].time
    steps = np.round(np.diff(time) * RATE)
    assert np.min(steps) == 1
    assert np.max(steps) >= 2


def test_truth_is_not_beside_the_logs(tmp_path: Path) -> None:
    case, clean = runs("torque_bump")
    for folder in (tmp_path, tmp_path / "logs", tmp_path / "logs" / "truth"):
        with pytest.raises(ValueError, match="apart from the logs"):
            write(case, clean, tmp_path / "logs", folder)
    written = write(case, clean, tmp_path / "logs", tmp_path / "sealed")
    assert sorted(p.name for p in (tmp_path / "logs").iterdir()) == [
        f"run{k:02d}.h5" for k in range(1, 5)
    ]
    assert [p.name for p in written.held_out] == ["run03.h5", "run04.h5"]
    text = b"".join(p.read_bytes() for p in (tmp_path / "logs").iterdir())
    for word in (b"torque_bump", b"single", b"hidden", b"sealed"):
        assert word not in text
    assert "torque_bump" in written.sealed.read_text()


def test_csv_and_hdf5_hold_the_same(tmp_path: Path) -> None:
    case, clean = runs("")
    write(case, clean, tmp_path / "a", tmp_path / "truth")
    write(case, clean, tmp_path / "b", tmp_path / "truth", "csv")
    lines = (tmp_path / "b" / "run02.csv").read_text().splitlines()
    assert lines[:4] == ["# run: 2", "# trajectory: a", "# pass: 2", "# payload: 0"]
    assert lines[4].startswith("time,theta[1],")
    assert lines[5].split(",")[:8] == ["s", *["rad"] * 6, "N m"]
    table = np.array([line.split(",") for line in lines[6:]], float)
    with h5py.File(tmp_path / "a" / "run02.h5") as file:
        assert file.attrs["pass"] == "2"
        assert file["tau_meas"].attrs["unit"] == "N m"
        columns: list[Array] = [np.array(file["time"])[:, None]]
        columns += [np.array(file[name]) for name in ("theta", "tau_meas", "tau", "r")]
    assert np.array_equal(table, np.concatenate(columns, axis=1))
