"""Where a user's base model comes from: `FILE.py:NAME`, or an installed package's entry point.

[project.entry-points."flexhex.bases"]
delta = "my_package.delta:Delta"
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from flexhex.diagnosis.basemodels.own import NEEDED, error_line
from flexhex.fmus.common.errors import FlexhexError, MachineError, UsageError

GROUP = "flexhex.bases"
"""Group of entry points whose names `--base` takes."""


def offered() -> dict[str, EntryPoint]:
    """Base models of installed packages by name."""
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def split(text: str) -> tuple[Path, str] | None:
    """File and name of `FILE.py:NAME`; the name is empty in `FILE.py`. None for any other text."""
    file, colon, name = text.rpartition(":")
    if colon and file.endswith(".py"):
        return Path(file), name
    return (Path(text), "") if text.endswith(".py") else None


def refuse_missing(file: Path, text: str, option: str = "--base") -> None:
    """UsageError for a file of `--base` or `--effect` that is not there."""
    if not file.is_file():
        raise UsageError(
            f"{option} {text}: no such file {file}; `flexhex init {file}` writes an example"
        )


def from_file(
    file: Path,
    name: str,
    needed: Sequence[str] = NEEDED,
    option: str = "--base",
    what: str = "base model",
) -> object:
    """The model NAME of FILE.py; a class or function is called without arguments.

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


def from_package(entry: EntryPoint) -> object:
    """The model of an entry point. MachineError when its package cannot be loaded."""
    try:
        model = entry.load()
    except Exception as error:
        raise MachineError(
            f"base model {entry.name} ({entry.value}): {error_line(error)}"
        ) from error
    return instance_of(model, f"base model {entry.name}")


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
