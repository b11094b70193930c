"""System descriptions taken apart and changed."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path


def members(path: Path) -> dict[str, bytes]:
    """Contents of an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def changed(path: Path, target: Path, change: Callable[[dict[str, bytes]], object]) -> Path:
    """A copy of an archive after change(members)."""
    files = members(path)
    change(files)
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return target


def heavy(fmu: bytes, size: int) -> bytes:
    """The FMU with a further resource that is declared to unpack to size [bytes]; it holds one."""
    packed = io.BytesIO(fmu)
    with zipfile.ZipFile(packed, "a") as archive:
        archive.writestr("resources/heavy", b"x")
    data = bytearray(packed.getvalue())
    at = data.rindex(b"PK\x01\x02")
    data[at + 24 : at + 28] = struct.pack("<I", size)
    return bytes(data)


def edited(
    path: Path, target: Path, old: str, new: str, member: str = "SystemStructure.ssd"
) -> Path:
    """A copy of an archive with one text replaced in one member."""

    def replace(files: dict[str, bytes]) -> None:
        assert old.encode() in files[member], f"{old} is not in {member}"
        files[member] = files[member].replace(old.encode(), new.encode())

    return changed(path, target, replace)
