"""`identify --out FOLDER`: a folder for what is written, as that of `diagnose`."""

from __future__ import annotations

from pathlib import Path

from flexhex.diagnose.options import writable
from flexhex.fmus.common.errors import UsageError

NAME = "identified"
"""Of the files in it."""
WRITTEN_BACK = (".urdf", ".xml")
"""Kinds of robots' files that are written with the new values; all values stand beside."""
FILES = (*WRITTEN_BACK, ".toml", ".csv", ".json", ".fmu")


def beside(write: Path | None) -> list[Path]:
    """What is written at a place: of a robot's file also what stands beside it."""
    if write is None:
        return []
    robot = write.suffix in WRITTEN_BACK
    return [write, *(write.with_suffix(kind) for kind in (".toml", ".json") if robot)]


def target(write: Path | None, out: Path | None, base: str) -> Path | None:
    """The file that `--write` names, or its place in the folder of `--out`, which is made.

    UsageError or OutputError, before anything is computed, for a folder that is none.
    """
    if out is None:
        return write
    if write is not None:
        raise UsageError(f"--out {out}: --write {write} names the file already: take one of them")
    if out.suffix in FILES and not out.is_dir():
        raise UsageError(
            f"--out {out}: must be a folder, as of `diagnose`; a file is --write {out}"
        )
    from flexhex.diagnosis.basemodels.robot_more import read_more

    suffix = read_more(base).file.suffix
    kind = ".toml" if base == "hexapod" else suffix if suffix in WRITTEN_BACK else ".json"
    file = out / f"{NAME}{kind}"
    writable("--out", file)
    return file
