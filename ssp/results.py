"""Results are written and read by the ending of the file: HDF5, CSV, MCAP, MAT, Parquet.

    from flexhex.ssp.results import load, save
    save(result, "runs/fixed.csv")
    load("runs/fixed.csv")["plant.theta"]

All of them read back exactly.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

from flexhex.fmus.common.errors import LogError, UsageError, unreadable
from flexhex.ssp.result import FORMAT, VERSION, Array, FmuTime, Group, Meta, Result, rate_name

__all__ = [
    "FORMAT",
    "VERSION",
    "Array",
    "FmuTime",
    "Group",
    "Meta",
    "Result",
    "check_target",
    "load",
    "provenance",
    "rate_name",
    "save",
]
FORMATS = {
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".csv": "csv",
    ".mat": "mat",
    ".parquet": "parquet",
    ".mcap": "mcap",
}
"""Module of `flexhex.ssp.formats` by the ending of a file."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def provenance(**more: str | int | float) -> dict[str, str | int | float]:
    """Versions of what takes part, with what the caller adds (command, machine, ...)."""
    meta: dict[str, str | int | float] = {"python": platform.python_version()}
    for package in ("flexhex", "casadi", "fmpy", "numpy"):
        try:
            meta[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            meta[package] = "not installed"
    from flexhex.fmugen.compile import version

    meta["compiler"] = version()
    return meta | more


def check_target(path: str | Path) -> None:
    """Whether a result can be written there, before hours of computing; nothing is created.

    Raises UsageError for an unknown ending or a missing package, LogError for a folder in its
    place and a place without permission.
    """
    target = Path(path)
    try:
        if target.is_dir():
            raise LogError(f"{target}: is a folder: name a file in it, as in {target / 'run.h5'}")
        writer = _format(target)
        if hasattr(writer, "check_installed"):
            writer.check_installed(target)
        folder = target.parent.absolute()
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        if not folder.is_dir():
            raise LogError(f"{target}: cannot be written: {folder} is a file, not a folder")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise LogError(f"{target}: cannot be written: no permission to write into {folder}")
    except OSError as error:
        raise LogError(f"{target}: cannot be written: {_reason(error)}") from None


def save(result: Result, path: str | Path, meta: Meta | None = None) -> Path:
    """Write a result in the format of the ending; meta is added to that of the result.

    Missing folders are created; the file appears when it is complete. Raises what
    `check_target` raises, and LogError when writing fails.
    """
    target = Path(path)
    check_target(target)
    partial = target.with_name(target.name + ".part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _format(target).write(partial, result, {**result.meta, **(meta or {})})
        return partial.replace(target)
    except OSError as error:
        raise LogError(f"{target}: cannot be written: {_reason(error)}") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)


def load(path: str | Path) -> Result:
    """Read a result in the format of the ending. Raises LogError for a missing, broken or foreign
    file."""
    source = Path(path)
    try:
        with source.open("rb") as file:
            begin = file.read(len(HDF5_SIGNATURE))
    except OSError as error:
        raise LogError(unreadable(path, error)) from None
    suffix = source.suffix.lower()
    if suffix not in FORMATS and begin != HDF5_SIGNATURE:
        ending = f"unknown ending {suffix!r}" if suffix else "has no ending"
        raise LogError(f"{path}: {ending}: results are read from {', '.join(FORMATS)}")
    name = "hdf5" if begin == HDF5_SIGNATURE else FORMATS[suffix]
    result: Result = importlib.import_module(f"flexhex.ssp.formats.{name}").read(source)
    return result


def _format(target: Path) -> Any:
    """The module that writes files of this ending; UsageError for another one."""
    name = FORMATS.get(target.suffix.lower())
    if name is None:
        ending = f"unknown ending {target.suffix!r}" if target.suffix else "has no ending"
        raise UsageError(f"{target}: {ending}: results are written as {', '.join(FORMATS)}")
    return importlib.import_module(f"flexhex.ssp.formats.{name}")


def _reason(error: OSError) -> str:
    """Why the system refused, without the words of the library that asked it."""
    return os.strerror(error.errno) if error.errno else "is the disk full?"
