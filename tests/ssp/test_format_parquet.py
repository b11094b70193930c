"""Parquet: one table on one time, which reads back; what is missing or foreign is said."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.formats.parquet import check_installed
from flexhex.ssp.result import Result
from flexhex.ssp.results import check_target, load, save
from tests.ssp.test_formats import N, result

__all__ = ["result"]


def test_parquet_holds_all_rates_on_one_time(result: Result, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(save(result, tmp_path / "ü.parquet"))
    assert table["time"].to_numpy().tobytes() == result.time("plant.theta").tobytes()
    e = table["feedback.e[3]"].to_numpy()
    assert e.tobytes() == result["feedback.e"][:, 2].tobytes()
    p = table["K.p.lower.J_xx"]
    assert p.null_count == N - 6
    assert p.drop_null().to_numpy().tobytes() == result["K.p"][:, 1].tobytes()
    assert p.is_valid().to_numpy().nonzero()[0].tolist() == list(range(0, N, 1000))
    assert table.schema.field("K.p.lower.J_xx").metadata[b"unit"] == b"kg m2"
    assert table.schema.metadata[b"case"] == b"fixed"


def test_what_is_no_result_or_damaged_is_said(result: Result, tmp_path: Path) -> None:
    arrow = pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(save(result, tmp_path / "r.parquet"))
    about = table.schema.metadata[b"flexhex_result"]
    named = {b"flexhex_result": about}
    newer = {b"flexhex_result": about.replace(b'"version": 1', b'"version": 9')}
    parquet.write_table(arrow.table({"theta": [1.0]}), tmp_path / "log.parquet")
    parquet.write_table(table.replace_schema_metadata(newer), tmp_path / "9.parquet")
    short = table.slice(0, 5).replace_schema_metadata(named)
    parquet.write_table(short, tmp_path / "short.parquet")
    narrow = table.select(range(4)).replace_schema_metadata(named)
    parquet.write_table(narrow, tmp_path / "narrow.parquet")
    (tmp_path / "noise.parquet").write_bytes(bytes(range(256)))
    for name, reason in (
        ("log", "a Parquet file, but not a result"),
        ("9", "version 9 of the format, this program reads 1"),
        ("short", "damaged result"),
        ("narrow", "damaged result"),
        ("noise", "not a readable Parquet file"),
    ):
        with pytest.raises(LogError, match=f"{name}.parquet: .*{reason}"):
            load(tmp_path / f"{name}.parquet")


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    path = tmp_path / "r.parquet"
    for check in (check_installed, check_target):
        with pytest.raises(UsageError, match=r"pip install 'flexhex\[parquet\]'"):
            check(path)
    path.touch()
    with pytest.raises(LogError, match=r"reading .parquet needs .*'flexhex\[parquet\]'"):
        load(path)
