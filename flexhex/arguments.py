"""Options that several commands share, and the machine files that come with the package."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

DEFAULT_MACHINE = Path("machines/tflex.toml")
"""The T-Flex: this path in the current folder, else the file of the package."""
SHIPPED = Path(__file__).parent / "machines"

PLATFORMS = ("linux64", "win64", "aarch64-linux", "darwin64")
"""What `--platform` takes."""

MachineFile = Annotated[
    Path, typer.Option("--machine", "-m", help="machine file (TOML)", show_default=True)
]
OutFolder = Annotated[Path, typer.Option("--out", "-o", help="folder for everything generated")]
Trajectory = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="own motion (CSV): angles r or poses x_E, phi_E; docs/motion.md"
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="print the result as JSON on stdout")]


def machine_file_of(path: Path) -> Path:
    """The machine file; the package's own if the default is not in the current folder."""
    if path == DEFAULT_MACHINE and not path.exists():
        return SHIPPED / path.name
    return path


def listed_values(incomplete: str, values: Iterable[str]) -> list[str]:
    """Completions of a comma-separated list: what is typed so far and one more of the values."""
    before, comma, last = incomplete.rpartition(",")
    taken = before.split(",")
    return [
        f"{before}{comma}{value}"
        for value in values
        if value.startswith(last) and value not in taken
    ]


def command_line() -> str:
    """The command line as typed, without the folder of the program."""
    return " ".join([Path(sys.argv[0]).name, *sys.argv[1:]])
