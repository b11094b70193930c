"""Archives (.fmu, .ssp) are opened here and nowhere else: what could do harm is refused first."""

from __future__ import annotations

import io
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from flexhex.fmus.common.errors import InterfaceError, unreadable

MOST_BYTES = 2**30
"""What an archive may unpack to [bytes], and all FMUs of a .ssp together. Ours are below 20 MB for
four platforms, FMUs of whole vehicles some hundred; beyond, memory and disks of ordinary computers
are at stake."""
MOST_MEMBERS = 20_000
"""Files in an archive; ours have a hundred."""


def open_zip(file: bytes | str | Path, name: str) -> zipfile.ZipFile:
    """An archive from its bytes or its path; `name` is for messages.

    Nothing is unpacked here, and sizes are those that the archive declares: more than these no
    member gives. InterfaceError for no file, no zip, one that unpacks to more than MOST_BYTES or
    MOST_MEMBERS, and for members that are links, lead outside, or are both file and folder.
    """
    try:
        archive = zipfile.ZipFile(io.BytesIO(file) if isinstance(file, bytes) else file)
    except (zipfile.BadZipFile, ValueError):
        text = "not a zip archive, or a truncated one: copy or build it anew"
        raise InterfaceError(f"{name}: {text}") from None
    except OSError as error:
        raise InterfaceError(unreadable(name, error)) from None
    objection = _objection(archive.infolist())
    if objection:
        archive.close()
        raise InterfaceError(f"{name}: {objection}")
    return archive


def _objection(members: list[zipfile.ZipInfo]) -> str:
    if len(members) > MOST_MEMBERS:
        return f"holds {len(members)} files, at most {MOST_MEMBERS} are opened"
    if too_much := size_objection(unpacked_size(members)):
        return too_much
    files = {m.filename for m in members if not m.is_dir()}
    for member in members:
        path, kind = PurePosixPath(member.filename), stat.S_IFMT(member.external_attr >> 16)
        if "\\" in member.filename or ".." in path.parts or path.is_absolute():
            return f"{member.filename}: not a path inside the archive, importers refuse it"
        if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
            return f"{member.filename}: a link or a device, must be a file"
        above = next((str(p) for p in path.parents if str(p) in files), None)
        if above:
            return f"{above} is a file, and the folder of {member.filename}"
    return ""


def unpacked_size(members: list[zipfile.ZipInfo]) -> int:
    """What the files of an archive unpack to, as it declares them [bytes]."""
    return sum(member.file_size for member in members)


def size_objection(size: int) -> str:
    """Why an archive that unpacks to so many bytes is not opened; empty for one that is."""
    if size <= MOST_BYTES:
        return ""
    return f"unpacks to {size / 2**20:.0f} MB, at most {MOST_BYTES // 2**20} MB are opened"


def read_member(archive: zipfile.ZipFile, name: str, file: str) -> bytes:
    """One file of an archive; InterfaceError when it is missing or damaged."""
    with _undamaged(name, file):
        return archive.read(name)


def check_members(archive: zipfile.ZipFile, file: str) -> None:
    """InterfaceError for the first member that is no longer, or never was, what is declared."""
    for name in archive.namelist():
        with _undamaged(name, file), archive.open(name) as member:
            while member.read(2**20):
                pass


@contextmanager
def _undamaged(name: str, file: str) -> Iterator[None]:
    try:
        yield
    except KeyError:
        raise InterfaceError(f"{file}: {name} is missing in the archive") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, ValueError) as error:
        raise InterfaceError(f"{file}: {name} is damaged in the archive ({error})") from None


def read_bytes(path: str | Path) -> bytes:
    """Contents of a file; InterfaceError when it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InterfaceError(unreadable(path, error)) from None
