"""Options that say which model of the mechanism logs are compared with; shared by `diagnose` and
`identify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, machine_file_of
from flexhex.fmus.common.errors import UsageError

if TYPE_CHECKING:
    from flexhex.diagnosis.logs import Options as LogOptions
    from flexhex.diagnosis.prepare import Options

KINDS = ("hexapod", "axis")
"""Names that come with the package."""

Base = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="model of the mechanism: hexapod, axis (each by itself), a"
        " robot's file (.urdf, MJCF .xml, .sdf, or .toml beside one), or one of your own,"
        " FILE.py:NAME",
        autocompletion=lambda incomplete: [b for b in KINDS if b.startswith(incomplete)],
    ),
]
Joints = Annotated[
    str,
    typer.Option(
        metavar="NAME,NAME,...",
        help="joints of a robot's file, in the order of the logs' axes; the others are locked",
    ),
]
Tolerances = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=VALUE",
        help="one standard deviation of what a machine's or robot's file says, relative, in"
        " place of its [tolerance]: mass=0.1; also inertia, centre, stiffness, actuator, sigma,"
        " geometry, gravity, effects",
    ),
]

OwnEffects = Annotated[
    list[str] | None,
    typer.Option(
        "--effect",
        metavar="FILE.py:NAME",
        help="an effect of your own beside the library's (`flexhex init effect.py` writes an"
        " example), or the name of one that a package offers",
    ),
]


def base_options(
    base: str,
    machine: Path | None,
    joints: str,
    tolerance: list[str] | None,
    log: LogOptions,
    effects: list[str] | None = None,
) -> tuple[Options, Path | None]:
    """How to compare, and the machine file of a hexapod. UsageError for what does not go
    together."""
    from flexhex.diagnosis.basemodels.bases import known_base
    from flexhex.diagnosis.basemodels.robot_file import is_robot
    from flexhex.diagnosis.prepare import Options

    known_base(base)
    if machine is not None and base != "hexapod":
        raise UsageError(
            f"--machine {machine}: --base {base} reads no machine file: take --machine out"
        )
    file = machine_file_of(machine or DEFAULT_MACHINE) if base == "hexapod" else None
    if tolerance and base != "hexapod" and not is_robot(base):
        raise UsageError(f"--tolerance: --base {base} reads no machine file: take it out")
    known = tolerances(tolerance or [], base)
    named = tuple(name.strip() for name in joints.split(",") if name.strip())
    return Options(base, log, tolerance=known, joints=named, effects=tuple(effects or [])), file


def read_of(options: Options, machine: Path | None) -> list[Path]:
    """Files that are read beside logs."""
    from flexhex.diagnosis.basemodels.robot_file import is_robot
    from flexhex.diagnosis.basemodels.robot_more import read_more
    from flexhex.fmus.common.user_code import split

    named = [split(text) for text in (options.base, *options.effects)]
    files = [own[0] for own in named if own is not None]
    if is_robot(options.base):
        files += [Path(options.base), read_more(options.base).file]
    return files if machine is None else [*files, machine]


def tolerances(words: list[str], base: str) -> dict[str, float]:
    """`mass=0.1` and the like, by the keys that there are for a base model. UsageError for what is
    none of them, or no such number."""
    from flexhex.diagnosis.basemodels.robot_file import is_robot
    from flexhex.diagnosis.basemodels.tolerances import RobotTolerance, with_tolerance
    from flexhex.fmus.common.machine.sections import Tolerance

    values: dict[str, float] = {}
    for word in words:
        name, _, text = word.partition("=")
        try:
            values[name] = float(text)
        except ValueError:
            raise UsageError(f"--tolerance {word}: write KEY=NUMBER, such as mass=0.1") from None
    with_tolerance(RobotTolerance() if is_robot(base) else Tolerance(), values)
    return values
