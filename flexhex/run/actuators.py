"""The actuators alone, [SH, Table I] right: a machine file `<machine>-actuators.toml`."""

from __future__ import annotations

from pathlib import Path

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine_file import read_toml
from flexhex.simulation.builder import Builder


def actuators_file(machine_file: Path) -> Path:
    """`tflex.toml` -> `tflex-actuators.toml`."""
    return machine_file.with_name(f"{machine_file.stem}-actuators.toml")


def actuators_builder(builder: Builder) -> Builder | None:
    """Builder of the actuators alone, checked; None without their file.

    MachineError when the file does not extend this machine's, or has a platform.
    """
    path = actuators_file(builder.machine_file)
    if not path.exists():
        return None
    base = read_toml(path).get("extends")
    if base is None or (path.parent / str(base)).resolve() != builder.machine_file.resolve():
        raise MachineError(
            f"{path}: extends: wants {builder.machine_file.name!r}, is {base!r}: its rows stand"
            " beside that machine's, so extend it, or give this file another name"
        )
    alone = Builder(path, builder.out / "actuators", builder.say)
    if alone.machine.has_platform:
        raise MachineError(f"{path}: has a platform: add `without_platform = true`")
    alone.check()
    return alone
