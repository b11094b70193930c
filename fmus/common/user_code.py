"""Where what a user wrote in Python comes from: `FILE.py:NAME`, or a package's entry point.

[project.entry-points."flexhex.bases"]
delta = "my_package.delta:Delta"

[project.entry-points."flexhex.effects"]
gas_spring = "my_package.springs:GasSpring"
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from flexhex.fmus.common.errors import FlexhexError, MachineError, UsageError

BASE_GROUP, EFFECT_GROUP = "flexhex.bases", "flexhex.effects"
"""Groups of entry points: names that `--base` takes, and `--effect` and machine files."""


def offered(group: str) -> dict[str, EntryPoint]:
    """What installed packages offer in a group, by name."""
    return {entry.name: entry for entry in entry_points(group=group)}


def split(text: str) -> tuple[Path, str] | None:
    """File and name of `FILE.py:NAME`; the name is empty in `FILE.py`. None for any other text."""
    file, colon, name = text.rpartition(":")
    if colon and file.endswith(".py"):
        return Path(file), name
    return (Path(text), "") if text.endswith(".py") else None


def absolute(text: str, folder: Path) -> str:
    """`FILE.py:NAME`, seen from a folder, with its whole path; any other text as it is."""
    place = split(text)
    return f"{(folder / place[0]).resolve().as_posix()}:{place[1]}" if place else text


def relative(text: str, folder: Path) -> str:
    """`FILE.py:NAME` as it is seen from a folder; any other text as it is."""
    place = split(text)
    if place is None:
        return text
    return f"{Path(os.path.relpath(place[0].resolve(), folder.resolve())).as_posix()}:{place[1]}"


def refuse_missing(file: Path, text: str, option: str) -> None:
    """UsageError for a file of an option, or of a key of a machine file, that is not there."""
    if not file.is_file():
        raise UsageError(
            f"{option} {text}: no such file {file}; `flexhex init {file}` writes an example"
        )


def from_file(file: Path, name: str, needed: Sequence[str], option: str, what: str) -> object:
    """The object NAME of FILE.py; a class or function is called without arguments.

    needed: members by which one is known; option, what: how messages call it.

    Raises MachineError for a file that cannot be run, and for one that has no such name.
    """
    module = _run(file)
    usable = [own for own, value in vars(module).items() if all(hasattr(value, m) for m in needed)]
    if not name or not hasattr(module, name):
        has = f"it has {', '.join(usable)}" if usable else f"it has no {what}"
        missing = f"no {name!r} in it" if name else "no name given"
        example = usable[0] if usable else "NAME"
        raise MachineError(f"{file}: {missing}; {has}: write {option} {file}:{example}")
    return instance_of(getattr(module, name), f"{file}:{name}", str(file.resolve()))


def from_package(entry: EntryPoint, what: str) -> object:
    """The object of an entry point; what: how messages call it. MachineError when its package
    cannot be loaded."""
    try:
        model = entry.load()
    except Exception as error:
        raise MachineError(f"{what} {entry.name} ({entry.value}): {error_line(error)}") from error
    return instance_of(model, f"{what} {entry.name}")


def instance_of(model: object, name: str, file: str = "") -> object:
    """A class or function called, any other object as it is. MachineError where that fails."""
    if not callable(model):
        return model
    try:
        return model()
    except FlexhexError:
        raise
    except Exception as error:
        raise MachineError(
            f"{name}: called without arguments, it fails: {error_line(error, file)}"
        ) from error


def error_line(error: BaseException, file: str = "") -> str:
    """An error of a user's code in a line: where in the file it was raised (last, or in `file`)."""
    at, trace = 0, error.__traceback__
    while trace is not None:
        if not file or trace.tb_frame.f_code.co_filename == file:
            at = trace.tb_lineno
        trace = trace.tb_next
    where = f" (line {at})" if at else ""
    return f"{type(error).__name__}: {error}{where}"


def _run(file: Path) -> ModuleType:
    """The file as a module; files beside it can be imported from it."""
    path = file.resolve()
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    name = f"flexhex_base_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise MachineError(f"{file}: cannot be loaded as Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look themselves up there
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise MachineError(f"{file}: {error.msg} (line {error.lineno})") from error
    except Exception as error:
        raise MachineError(f"{file}: {error_line(error, str(path))}") from error
    return module
