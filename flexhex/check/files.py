"""`flexhex check`: complaints about an FMU, a system description or a machine file.

`check_fmu` (archive, variables, structure, the binary in a child process), `check_ssp`.
"""

from __future__ import annotations

from pathlib import Path

from flexhex.fmus.common.errors import FlexhexError, InterfaceError, unreadable


def check_file(path: Path) -> list[str]:
    """Complaints, none when all is well. InterfaceError for no file, or one of another kind."""
    if not path.is_file():
        missing = IsADirectoryError() if path.is_dir() else FileNotFoundError()
        raise InterfaceError(unreadable(path, missing))
    if path.suffix not in _CHECKS:
        raise InterfaceError(
            f"{path}: nothing to check in {path.suffix!r}, wants {', '.join(_CHECKS)}"
        )
    try:
        return _CHECKS[path.suffix](path)
    except FlexhexError as error:
        return str(error).splitlines()


def warnings_of(path: Path) -> list[str]:
    """What is allowed in a file without complaints, and yet may be a mistake."""
    from flexhex.fmus.common.machine_file import is_truth, load_machine, read_toml
    from flexhex.simulation.machine_check import doubts

    if path.suffix != ".toml" or path.stem.endswith("-published") or is_truth(read_toml(path)):
        return []
    return [f"{path}: warning: {text}" for text in doubts(load_machine(path))]


def _fmu(path: Path) -> list[str]:
    from flexhex.check.fmu import check_fmu

    return check_fmu(path)


def _ssp(path: Path) -> list[str]:
    from flexhex.check.ssp import check_ssp

    return check_ssp(path)


def _toml(path: Path) -> list[str]:
    from flexhex.fmugen.blocks import machine_interface
    from flexhex.fmus.common.machine_file import is_truth, load_machine, read_toml
    from flexhex.simulation.builder import Builder
    from flexhex.simulation.machine_check import named
    from flexhex.simulation.published import published

    if path.stem.endswith("-published"):
        published(path.with_name(path.name.replace("-published", "")))
        return []
    if not is_truth(read_toml(path)):
        Builder(path, path.parent).check()
        return []
    belongs = path.with_name(path.name.replace("-truth.toml", ".toml"))
    if belongs == path or not belongs.is_file():
        return [f"{path}: a truth file without its machine file: name it <machine>-truth.toml"]
    named(path, lambda: machine_interface(load_machine(belongs), path), "machine")
    return []


_CHECKS = {".fmu": _fmu, ".ssp": _ssp, ".toml": _toml}
