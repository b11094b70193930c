"""Archives taken apart, changed and put together again; binaries from changed sources."""

from __future__ import annotations

import subprocess
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

from flexhex.fmugen.compile import compiler

Files = dict[str, bytes]
Change = Callable[[Files], None]
XML = "modelDescription.xml"


def members(path: Path) -> Files:
    """Contents of an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def write(path: Path, files: Files) -> Path:
    """An archive of these files."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def text(old: str, new: str, member: str = XML, count: int = 1) -> Change:
    """Replace a text in a member; it must be there."""

    def change(files: Files) -> None:
        assert old.encode() in files[member], f"{old!r} is not in {member}"
        files[member] = files[member].replace(old.encode(), new.encode(), count)

    return change


def passage_out(start: str, end: str, member: str = XML) -> Change:
    """Leave out a text of a member, from its start to its end; it must be there."""

    def change(files: Files) -> None:
        first = files[member].index(start.encode())
        last = files[member].index(end.encode(), first) + len(end)
        files[member] = files[member][:first] + files[member][last:]

    return change


def without(member: str) -> Change:
    """Leave a member out; it must be there."""

    def change(files: Files) -> None:
        del files[member]

    return change


def rebuilt(member: str, old: str, new: str, also: Change | None = None) -> Change:
    """Another binary: compiled from the archive's sources after a change of one, which stays."""

    def change(files: Files) -> None:
        library = next(n for n in files if n.startswith("binaries/linux64/"))
        kept = dict(files)
        text(old, new, f"sources/{member}")(kept)
        with tempfile.TemporaryDirectory() as folder:
            for name, data in kept.items():
                if name.startswith("sources/") and name.endswith((".c", ".h")):
                    (Path(folder) / Path(name).name).write_bytes(data)
            sources = sorted(p.name for p in Path(folder).glob("*.c"))
            flags = ["-std=c99", "-O0", "-w", "-shared", "-fPIC", "-ffp-contract=off"]
            command = [*compiler(), *flags, *sources, "-lm", "-o", "lib.so"]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr[:1000]
            files[library] = (Path(folder) / "lib.so").read_bytes()
        if also:
            also(files)

    return change
