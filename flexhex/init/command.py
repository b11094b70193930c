"""Command `init`: a file that users write themselves, to begin with: base model, effect, robot or
machine."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from flexhex.fmus.common.errors import OutputError, UsageError


class Kind(StrEnum):
    """What there are examples of."""

    base = "base"
    effect = "effect"
    robot = "robot"


HERE = Path(__file__).parent
EXAMPLES = {
    Kind.base: (HERE / "two_links.py", "--base {}:TwoLinks"),
    Kind.effect: (HERE / "gas_spring.py", "--effect {}:GasSpring"),
    Kind.robot: (HERE / "robot.toml", "--base {}"),
}
"""Files, and the option that takes one."""


def init_command(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="file to write: .toml a hexapod's machine file, or robot.toml; .py an example",
        ),
    ],
    kind: Annotated[
        Kind | None,
        typer.Option(
            help="default: a robot or an effect where the file's name says so, else a hexapod's"
            " machine file (.toml) or a base model (.py)"
        ),
    ] = None,
    radius: Annotated[
        float, typer.Option(help="of the motors' axes from the centre [m]", min=1e-6)
    ] = 0.15,
    spacing: Annotated[float, typer.Option(help="of the two motors of a pair [m]", min=0.0)] = 0.16,
    platform_radius: Annotated[
        float, typer.Option(help="of the platform's joints from its centre [m]", min=1e-6)
    ] = 0.26,
    platform_spacing: Annotated[
        float, typer.Option(help="of the two joints of a pair on the platform [m]", min=0.0)
    ] = 0.06,
    upper: Annotated[float, typer.Option(help="length of the upper arms [m]", min=1e-6)] = 0.28,
    lift: Annotated[
        float, typer.Option(help="angle of the upper arms above the horizontal [rad]")
    ] = 0.2,
    height: Annotated[
        float, typer.Option(help="of the end-effector over the motor axes, at rest [m]")
    ] = 0.3,
) -> None:
    """Write a machine file of your own hexapod and draw it, or an example of another file.

    FILE.toml: three pairs of arms of the given lengths. The length of the lower arms follows; that
    the loops close is checked; FILE.html shows the machine in 3D. What is no geometry is the
    T-Flex's, for you to replace. FILE.py: two links in a vertical plane, for `diagnose --base`, or
    a gas spring, for `diagnose --effect`. robot.toml: what a robot's file cannot say, for
    `diagnose --base`.
    """
    if file.suffix not in (".toml", ".py"):
        raise UsageError(
            f"{file}: neither a machine file (.toml) nor an example (.py): name one of these"
        )
    kind = kind or _kind(file)
    if kind is not None:
        example, option = EXAMPLES[kind]
        if file.suffix != example.suffix:
            raise UsageError(f"{file}: --kind {kind.value} is a {example.suffix}: name it so")
        _write(file, example.read_text(encoding="utf-8"))
        print(f"written  {file}\nuse it   flexhex diagnose RUN... {option.format(file)}")
        return
    from flexhex.init.hexapod import Hexapod, draw, machine_text

    lengths = radius, spacing, platform_radius, platform_spacing, upper, lift, height
    text, machine = machine_text(Hexapod(*lengths), file)
    page = file.with_suffix(".html")
    if page.exists():
        raise OutputError(f"{page}: is there already: name another file")
    _write(file, text)
    draw(machine, page)
    print(f"written  {file}: the lower arms are {machine.platform.l:.6g} m long; the loops close")
    print(f"drawn    {page}")
    print(f"next     replace what is no geometry, then flexhex run --machine {file}")


def _kind(file: Path) -> Kind | None:
    """What a file's name says; None: a hexapod."""
    name = file.stem.lower()
    if file.suffix == ".toml":
        return Kind.robot if "robot" in name else None
    return Kind.effect if "effect" in name else Kind.base


def _write(file: Path, text: str) -> None:
    """A new file; OutputError where there is one already or it cannot be written."""
    try:
        with file.open("x", encoding="utf-8") as written:
            written.write(text)
    except FileExistsError:
        raise OutputError(f"{file}: is there already: name another file") from None
    except OSError as error:
        raise OutputError(f"{file}: cannot be written ({error.strerror})") from None
