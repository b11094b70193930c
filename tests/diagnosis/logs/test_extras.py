"""Parquet and MDF4 logs: read where the packages are installed, named where they are not."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import columns, motion


@pytest.mark.parametrize(
    ("package", "ending", "extra"), [("pyarrow", "parquet", "parquet"), ("asammdf", "mf4", "mdf")]
)
def test_missing_extra_is_named(
    package: str, ending: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it is installed: the import finds nothing."""
    for name in (package, f"{package}.parquet"):
        monkeypatch.setitem(sys.modules, name, None)
    path = tmp_path / f"a.{ending}"
    path.write_bytes(b"")
    with pytest.raises(LogError, match=rf"needs the package {package}: pip install .*{extra}"):
        read_log(path)


def test_parquet_is_read(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    names, units, values = columns(motion(0.5))
    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit})
        for name, unit in zip(names, units, strict=True)
    ]
    schema = pyarrow.schema(fields, metadata={"trajectory": "a"})
    parquet.write_table(pyarrow.table(list(values.T), schema=schema), tmp_path / "a.parquet")
    log = read_log(tmp_path / "a.parquet")
    assert np.array_equal(log.theta, values[:, 1:3])
    assert log.trajectory == "a"


def test_mdf_is_read(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra `mdf` is not installed")
    names, units, values = columns(motion(0.5))
    signals = [
        asammdf.Signal(values[:, k], values[:, 0], unit=units[k], name=names[k])
        for k in range(1, len(names))
    ]
    with asammdf.MDF() as file:
        file.append(signals)
        file.save(tmp_path / "a.mf4")
    assert np.array_equal(read_log(tmp_path / "a.mf4").theta, values[:, 1:3])


@pytest.fixture
def tables() -> Any:
    """pyarrow and its Parquet writer, where the extra is installed."""
    pyarrow = pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    return pyarrow, pytest.importorskip("pyarrow.parquet")


def stored(tables: Any, path: Path, time: Any, more: Any = None) -> Path:
    """A Parquet log with units; time: an array of pyarrow; more: what stands for the angles."""
    pyarrow, parquet = tables
    names, units, values = columns(motion(0.5))
    arrays = [time, *(pyarrow.array(c) for c in values.T[1:])]
    if more is not None:
        arrays[1] = more
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": unit})
        for name, unit, array in zip(names, units, arrays, strict=True)
    ]
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)
    return path


@pytest.mark.parametrize("kind", ["timestamp", "duration"])
def test_parquet_dates_are_seconds(kind: str, tables: Any, tmp_path: Path) -> None:
    """Not nanoseconds that call themselves seconds."""
    ns = pa_int(tables, columns(motion(0.5))[2][:, 0])
    stamps = ns.cast(getattr(tables[0], kind)("ns"))
    log = read_log(stored(tables, tmp_path / "a.parquet", stamps))
    assert log.ts == pytest.approx(5e-4, rel=1e-12)
    assert np.array_equal(log.theta, columns(motion(0.5))[2][:, 1:3])


def pa_int(tables: Any, seconds: Any) -> Any:
    """Whole nanoseconds."""
    return tables[0].array(np.rint(1e9 * seconds).astype(np.int64))


def test_parquet_lists_are_axes(tables: Any, tmp_path: Path) -> None:
    pyarrow, parquet = tables
    _, _, values = columns(motion(0.5))
    lists = [pyarrow.array(values[:, a:b].tolist()) for a, b in ((1, 3), (3, 5))]
    names = ["time [s]", "theta [rad]", "tau_meas [N m]"]
    parquet.write_table(pyarrow.table([values[:, 0], *lists], names=names), tmp_path / "a.parquet")
    assert np.array_equal(read_log(tmp_path / "a.parquet").theta, values[:, 1:3])


def test_parquet_texts_are_refused(tables: Any, tmp_path: Path) -> None:
    _, _, values = columns(motion(0.5))
    pyarrow = tables[0]
    words = pyarrow.array([str(v) for v in values[:, 1]])
    path = stored(tables, tmp_path / "a.parquet", pyarrow.array(values[:, 0]), words)
    with pytest.raises(LogError, match=r"theta\[1\] holds no numbers .*: write it as double"):
        read_log(path)


def mdf_file(path: Path, groups: list[list[int]], names: list[str] | None = None) -> Path:
    """An MDF4 log with the columns of each group in a channel group of its own."""
    asammdf = pytest.importorskip("asammdf", reason="the extra `mdf` is not installed")
    called, units, values = columns(motion(0.5))
    called = names or called
    with asammdf.MDF() as file:
        for group in groups:
            listed = [(values[:, k], values[:, 0], units[k], called[k]) for k in group]
            file.append([asammdf.Signal(v, t, unit=unit, name=name) for v, t, unit, name in listed])
        file.save(path)
    return path


def test_mdf_with_a_group_for_each_signal_is_read(tmp_path: Path) -> None:
    log = read_log(mdf_file(tmp_path / "a.mf4", [[1], [2], [3], [4]]))
    assert np.array_equal(log.theta, columns(motion(0.5))[2][:, 1:3])
    assert log.same_clock


def test_mdf_of_other_names_is_named_and_can_be_renamed(tmp_path: Path) -> None:
    path = mdf_file(tmp_path / "a.mf4", [[1, 2, 3, 4]], ["time", "q1", "q2", "T1", "T2"])
    with pytest.raises(LogError, match=r"it has .*q1, q2, T1, T2: name them with --rename"):
        read_log(path)
    log = read_log(path, Options(rename={"q": "theta", "T": "tau_meas"}))
    assert np.array_equal(log.theta, columns(motion(0.5))[2][:, 1:3])


@pytest.mark.parametrize(("package", "ending"), [("pyarrow", "parquet"), ("asammdf", "mf4")])
@pytest.mark.parametrize("content", [b"", b"hello" * 100])
def test_broken_file_of_an_extra_is_refused(
    package: str, ending: str, content: bytes, tmp_path: Path
) -> None:
    pytest.importorskip(package)
    path = tmp_path / f"a.{ending}"
    path.write_bytes(content)
    with pytest.raises(LogError, match="not a readable"):
        read_log(path)
