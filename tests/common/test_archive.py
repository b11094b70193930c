"""Archives that could do harm are refused before anything is unpacked."""

from __future__ import annotations

import re
import struct
import zipfile
from pathlib import Path

import pytest

from flexhex.check.fmu import check_fmu
from flexhex.fmus.common import archive
from flexhex.fmus.common.archive import open_zip
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.fmu import read_fmu
from flexhex.ssp.read import read_ssp
from tests.conftest import ROOT


def packed(path: Path, *members: tuple[str, bytes, int]) -> Path:
    """An archive of members: name, content, Unix mode (0: none)."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data, mode in members:
            info = zipfile.ZipInfo(name)
            info.external_attr = mode << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(info, data)
    return path


def declared_larger(path: Path, size: int) -> Path:
    """The size of the first member as the archive's directory declares it."""
    data = bytearray(path.read_bytes())
    at = data.index(b"PK\x01\x02")
    data[at + 24 : at + 28] = struct.pack("<I", size)
    path.write_bytes(bytes(data))
    return path


@pytest.mark.parametrize(
    ("member", "says"),
    [
        (("resources/a", b"/etc/passwd", 0o120777), "resources/a: a link or a device"),
        (("resources/../../a", b"x", 0), "resources/../../a: not a path inside the archive"),
        (("/tmp/a", b"x", 0), "/tmp/a: not a path inside the archive"),
        (("a\\b", b"x", 0), r"a\b: not a path inside the archive"),
        (("x/y", b"x", 0), "x is a file, and the folder of x/y"),
    ],
)
def test_member_that_could_do_harm_is_refused(
    tmp_path: Path, member: tuple[str, bytes, int], says: str
) -> None:
    path = packed(tmp_path / "some.fmu", ("x", b"x", 0o100644), member)
    for read in (lambda: open_zip(path, "some.fmu"), lambda: read_fmu(path.read_bytes(), "some")):
        with pytest.raises(InterfaceError, match=re.escape(says)):
            read()


def test_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    """4 GB declared; it holds a byte, so whoever unpacked it would say something else."""
    path = declared_larger(packed(tmp_path / "a.fmu", ("bomb", b"x", 0)), 2**32 - 2)
    says = r"unpacks to 4096 MB, at most 1024 MB are opened$"
    for read in (check_fmu, read_ssp):
        with pytest.raises(InterfaceError, match=says):
            read(path)


def test_archive_of_too_many_files_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive, "MOST_MEMBERS", 2)
    members = [(str(k), b"", 0) for k in range(3)]
    with pytest.raises(InterfaceError, match="holds 3 files, at most 2 are opened"):
        open_zip(packed(tmp_path / "a.fmu", *members), "a.fmu")


def test_member_gives_no_more_than_it_declares(tmp_path: Path) -> None:
    """So a directory that declares too little does not help."""
    path = packed(tmp_path / "a.fmu", ("bomb", b"x" * 10**6, 0))
    with (
        open_zip(declared_larger(path, 10), "a.fmu") as opened,
        pytest.raises(zipfile.BadZipFile, match="CRC"),
    ):
        opened.read("bomb")


def test_archives_are_opened_in_one_place() -> None:
    """In the product; pack.py writes."""
    by_name = {
        str(path.relative_to(ROOT))
        for folder in ("build", "fmus", "ssp", "diagnosis", "flexhex")
        for path in (ROOT / folder).rglob("*.py")
        if re.search(r"ZipFile\(|extractall\(", path.read_text(encoding="utf-8"))
    }
    allowed = {"fmus/common/archive.py", "build/fmugen/pack.py", "flexhex/check/binary.py"}
    assert by_name <= allowed | {"flexhex/check/results.py"}
