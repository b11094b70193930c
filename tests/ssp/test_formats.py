"""Results in all formats: exact, with units, readable by others and by our logs."""

from __future__ import annotations

import csv
import errno
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from flexhex.diagnosis.logs import read_log
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.result import FmuTime, Group, Result
from flexhex.ssp.results import check_target, load, save

BASE = 2.5e-4
N = 5001
"""More rows than are written at a time."""
NAMES = (".actuator[1].o", ".lower.J_xx")


@pytest.fixture(scope="module")
def result() -> Result:
    """Three rates; values that a careless writer loses, names and texts that it breaks."""
    t = BASE * np.arange(N)
    theta = np.sin(2 * np.pi * t[:, None] * [1, 2, 3])
    e = theta / 3
    e[7], e[8], e[9, 0], e[10, 0] = np.nan, np.inf, -0.0, 5e-324
    p = np.arange(12.0).reshape(6, 2) / 7
    estimated = {"K.p": p, "K.p_std.lower.J_xx": p[:, 1]}
    fast = {"plant.theta": theta, "plant.tau_meas": 3 * theta, "feedback.e": e}
    slow = {"F.tau_ff": theta[::2], "F.fault": np.zeros(len(theta[::2]))}
    units = {"plant.theta": "rad", "plant.tau_meas": "N m", "feedback.e": "rad"}
    texts = {"plant.theta": 'angles, "encoder": ϑ', "feedback.e": "# r - theta"}
    groups = {
        "0.25ms": Group(1, BASE, fast, units, texts),
        "0.5ms": Group(2, BASE, slow, {"F.tau_ff": "N m", "F.fault": "1"}),
        "250ms": Group(1000, BASE, estimated, {"K.p": "N m,kg m2"}, {}, {"K.p": NAMES}),
    }
    meta = {
        "case": "fixed",
        "n": 3,
        "x": 0.1,
        "like a number": "3",
        "two": 'a: "b"\nc',
        "ö:%": "é ",
    }
    times = {"plant": FmuTime(0.25, 1e-4, N, 1, "größer: 1"), "F": FmuTime(0.1, 1e-5, 9, 0)}
    return Result(groups, times, 1.25, 0.5, meta)


@pytest.mark.parametrize(
    "name",
    ["r.h5", "r.hdf5", "r.csv", "R.CSV", "Läufe 1/größe ñ.csv", "r.mcap", "ü.mat", "ü.parquet"],
)
def test_result_reads_back_exactly(result: Result, tmp_path: Path, name: str) -> None:
    if name.endswith("parquet"):
        pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    path = save(result, tmp_path / name)
    assert path == tmp_path / name
    again = load(path)
    assert (again.times, again.meta) == (result.times, result.meta)
    assert [type(v) for v in again.meta.values()] == [type(result.meta[k]) for k in again.meta]
    assert (again.duration, again.wall) == (result.duration, result.wall)
    assert list(again.groups) == list(result.groups)
    for rate, group in result.groups.items():
        other = again.groups[rate]
        assert (other.period, other.base) == (group.period, group.base)
        assert set(other.signals) == set(group.signals)
        for signal, values in group.signals.items():
            assert other.signals[signal].shape == values.shape
            assert other.signals[signal].tobytes() == values.tobytes()
            assert other.units.get(signal) == group.units.get(signal, "")
            assert other.descriptions.get(signal) == group.descriptions.get(signal, "")
            assert other.columns(signal) == group.columns(signal)
    assert np.array_equal(again["K.p.lower.J_xx"], result["K.p"][:, 1])


def test_hdf5_holds_time_and_a_unit_for_each_parameter(result: Result, tmp_path: Path) -> None:
    with h5py.File(save(result, tmp_path / "r.h5"), "r") as file:
        for rate, group in result.groups.items():
            time = file["rates"][rate]["time"]
            assert time[()].tobytes() == group.time.tobytes()
            assert time.attrs["unit"] == "s"
        assert file["rates/250ms/K.p"].attrs["unit"].tolist() == ["N m", "kg m2"]
        assert file["rates/250ms/K.p"].attrs["elements"].tolist() == list(NAMES)
        assert file["rates/0.25ms/plant.theta"].attrs["unit"] == "rad"


def test_hdf5_without_time_and_with_joined_units_still_loads(
    result: Result, tmp_path: Path
) -> None:
    """As files before this version: no `time`, the units of an array in one string."""
    path = save(result, tmp_path / "r.h5")
    with h5py.File(path, "a") as file:
        for rate in file["rates"].values():
            del rate["time"]
        file["rates/250ms/K.p"].attrs["unit"] = "N m,kg m2"
    again = load(path)
    assert again.group("K.p").units["K.p"] == "N m,kg m2"
    assert again.time("K.p").tobytes() == result.time("K.p").tobytes()


def test_csv_is_a_table_of_numbers_with_names_and_units(result: Result, tmp_path: Path) -> None:
    """Read by nothing but the csv module: each rate beside its own time, blank where it ends."""
    text = save(result, tmp_path / "r.csv").read_text(encoding="utf-8")
    rows = list(csv.reader(line for line in text.splitlines() if not line.startswith("#")))
    names, units, *numbers = rows
    assert len({len(row) for row in rows}) == 1
    assert [k for k, name in enumerate(names) if name == "time"] == [0, 10, 15]
    assert dict(zip(names, units, strict=True))["K.p.lower.J_xx"] == "kg m2"
    column = [row[names.index("F.tau_ff[2]")] for row in numbers]
    assert [float(x) for x in column if x] == result["F.tau_ff"][:, 1].tolist()
    assert column[2501:] == [""] * 2500
    assert [float(row[15]) for row in numbers[:6]] == result.time("K.p").tolist()


@pytest.mark.parametrize("ending", ["h5", "csv", "mat", "mcap"])
def test_logs_are_read_from_results(result: Result, tmp_path: Path, ending: str) -> None:
    log = read_log(save(result, tmp_path / f"r.{ending}"))
    assert np.array_equal(log.theta, result["plant.theta"])
    assert np.array_equal(log.channels["tau_meas"].values, result["plant.tau_meas"])
    assert np.array_equal(log.channels["tau_ff"].values, result["F.tau_ff"])


def test_target_is_judged_before_anything_is_computed(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.h5").mkdir()
    for name, kind, reason in (
        ("r.txt", UsageError, "unknown ending '.txt': results are written as .h5, .hdf5, .csv"),
        ("r", UsageError, "has no ending"),
        ("folder.h5", LogError, "is a folder: name a file in it"),
        ("file/r.h5", LogError, "file is a file, not a folder"),
        ("n" * 300 + "/r.h5", LogError, "File name too long"),
    ):
        with pytest.raises(kind, match=reason):
            check_target(tmp_path / name)
    check_target(tmp_path / "new" / "folders" / "r.h5")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.h5"], "nothing is made"


@pytest.mark.parametrize("ending", ["h5", "csv", "mat", "mcap"])
def test_full_disk_is_said_and_leaves_nothing(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    old = save(result, tmp_path / f"r.{ending}").read_bytes()

    def full(self: Path, target: Path) -> Path:
        raise OSError(errno.ENOSPC, "no words of ours")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(LogError, match=r"cannot be written: No space left on device$"):
        save(result, tmp_path / f"r.{ending}")
    assert [p.name for p in tmp_path.iterdir()] == [f"r.{ending}"]
    assert (tmp_path / f"r.{ending}").read_bytes() == old


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("# format: flexhex-result", "# format: other", "not a result: it has no line `# format"),
        ("# version: 1", "# version: 9", "version 9 of the format, this program reads 1"),
        ('"rows": 6', '"rows": 7000', "damaged result"),
        ("K.p.lower", "K.q.lower", "damaged result.*names are not those"),
        ('"columns": 2', '"columns": 3', "damaged result"),
        ("# duration_s", "# length", "damaged result"),
        ("0.0,0.0,0.0", "0.0,zero,0.0", "damaged result.*zero"),
    ],
)
def test_broken_csv_is_refused(
    result: Result, tmp_path: Path, old: str, new: str, reason: str
) -> None:
    path = save(result, tmp_path / "r.csv")
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(LogError, match=f"r.csv: .*{reason}"):
        load(path)


def test_files_of_other_kinds_are_refused(result: Result, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,theta[1]\ns,rad\n0,1\n")
    (tmp_path / "noise.csv").write_bytes(bytes(range(256)))
    savemat(tmp_path / "log.mat", {"theta": np.arange(3.0)})
    (tmp_path / "noise.mat").write_bytes(bytes(range(256)))
    for name, reason in (
        ("log.csv", "a CSV file, but not a result"),
        ("noise.csv", "damaged result"),
        ("log.mat", "a MAT file, but not a result"),
        ("noise.mat", "not a readable MAT result"),
        ("", "is a folder"),
    ):
        with pytest.raises(LogError, match=reason):
            load(tmp_path / name)


def test_hdf5_that_is_named_csv_is_read(result: Result, tmp_path: Path) -> None:
    """As version 0.1 wrote it for `-r r.csv`."""
    save(result, tmp_path / "r.h5").rename(tmp_path / "r.csv")
    assert np.array_equal(load(tmp_path / "r.csv")["plant.theta"], result["plant.theta"])
