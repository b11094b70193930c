"""`flexhex check`: complaints about an FMU, a system description or a machine file."""

from __future__ import annotations

import zipfile
from pathlib import Path

from fmus.common.errors import FlexhexError, UsageError


def check_file(path: Path) -> list[str]:
    """Complaints, none when all is well. UsageError for a file of another kind."""
    if path.suffix not in _CHECKS:
        raise UsageError(f"{path}: nothing to check in {path.suffix!r}, wants {', '.join(_CHECKS)}")
    if not path.is_file():
        raise UsageError(f"{path}: no such file")
    try:
        return _CHECKS[path.suffix](path)
    except FlexhexError as error:
        return str(error).splitlines()


def _fmu(path: Path) -> list[str]:
    from fmpy.validation import validate_fmu

    if not zipfile.is_zipfile(path):
        return [f"{path}: not a zip archive, so no FMU"]
    try:
        return [f"{path}: {text}" for text in validate_fmu(str(path))]
    except Exception as error:  # fmpy raises plain Exception for unreadable descriptions
        return [f"{path}: {str(error).splitlines()[0]}"]


def _ssp(path: Path) -> list[str]:
    from ssp.read import read_ssp

    read_ssp(path)
    return []


def _toml(path: Path) -> list[str]:
    from fmugen.rooms import machine_interface

    from flexhex.build import Builder
    from flexhex.machine_check import named
    from fmus.common.machine_file import is_truth, load_machine, read_toml

    if not is_truth(read_toml(path)):
        Builder(path, path.parent).check()
        return []
    belongs = path.with_name(path.name.replace("-truth.toml", ".toml"))
    if belongs == path or not belongs.is_file():
        return [f"{path}: a truth file without its machine file: name it <machine>-truth.toml"]
    named(path, lambda: machine_interface(load_machine(belongs), path), "machine")
    return []


_CHECKS = {".fmu": _fmu, ".ssp": _ssp, ".toml": _toml}
