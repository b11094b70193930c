"""Reading machine files: `load_machine("machines/tflex.toml")` gives a frozen `Machine`.

What the file says about units and ranges is checked field by field; that bodies are
physical and that the mechanism closes is checked at the end. Every complaint is a
MachineError that names file, field and remedy.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from flexhex.fmus.common.errors import MachineError, unreadable
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import Frames
from flexhex.fmus.common.user_code import absolute


def load_machine(path: str | Path) -> Machine:
    """Read and check a machine file.

    Raises MachineError when the file is missing, is no TOML, lacks a field or has an
    unknown one, holds a wrong unit or an impossible value, or when the mechanism
    does not close at the neutral pose.
    """
    data = machine_data(Path(path))
    if is_truth(data):
        raise MachineError(
            f"{path}: a truth file: it says what the real machine has beyond its model; give the"
            " machine file it stands beside (tflex.toml for tflex-truth.toml)"
        )
    if "robot" in data and "geometry" not in data:
        raise MachineError(f"{path}: describes a robot: give it as --base {path}")
    try:
        machine = Machine.model_validate(data)
    except ValidationError as error:
        raise MachineError("\n".join(complaints(path, Machine, error.errors()))) from None
    Frames.of(machine, where=str(path))
    return machine


def machine_data(path: Path, seen: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Plain data of a machine file, `extends` and `without_platform` carried out.

    extends = "tflex.toml"      everything from there; top-level keys here replace theirs
    without_platform = true     no lower arms, no end-effector, no flexures
    diagnosed = true            what a diagnosis added, see `real_file`

    Files of own effects, `id = "gas_spring.py:GasSpring"`, get whole paths.
    """
    data = read_toml(path)
    listed = data.get("effects")
    for entry in listed if isinstance(listed, list) else []:
        if isinstance(entry, dict) and isinstance(id := entry.get("id"), str):
            entry["id"] = absolute(id, path.parent)
    data.pop("diagnosed", None)
    base = data.pop("extends", None)
    if base is not None:
        if path in seen or not isinstance(base, str):
            raise MachineError(f"{path}: extends: {base!r} must name another machine file")
        data = machine_data(path.parent / base, (*seen, path)) | data
    plain = all(isinstance(data.get(key, {}), dict) for key in ("geometry", "bodies"))
    arms = data.get("arms", [])
    plain = plain and isinstance(arms, list) and all(isinstance(arm, dict) for arm in arms)
    if data.pop("without_platform", False) and plain:
        data.pop("flexures", None)
        for section, keys in (("geometry", ("l", "x_E0")), ("bodies", ("lower", "end_effector"))):
            data[section] = {k: v for k, v in data.get(section, {}).items() if k not in keys}
        data["arms"] = [{k: v for k, v in arm.items() if k != "r_EP"} for arm in arms]
    return data


def is_truth(data: Mapping[str, Any]) -> bool:
    """Whether the data of a file are a truth: errors of a machine, and no machine."""
    return "errors" in data and "geometry" not in data


def truth_file(path: Path) -> Path:
    """The truth that belongs to a machine file: `tflex.toml` -> `tflex-truth.toml`.

    A file that extends another is another build of the same machine and shares its truth.
    """
    base = read_toml(path).get("extends")
    if base is not None:
        return truth_file(path.parent / str(base))
    return path.with_name(f"{path.stem}-truth.toml")


def real_file(path: Path) -> Path:
    """The machine file that machine.fmu is built from: what a diagnosis added to the model is in
    the machine already."""
    data = read_toml(path)
    base = data.get("extends")
    return real_file(path.parent / str(base)) if data.get("diagnosed") and base else path


def read_toml(path: str | Path) -> dict[str, Any]:
    """Plain data of a TOML file; MachineError when it is missing or no TOML."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise MachineError(unreadable(path, error)) from None
    except UnicodeDecodeError:
        raise MachineError(f"{path}: cannot be read: not a UTF-8 text") from None
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"{path}: not valid TOML: {error}") from None
