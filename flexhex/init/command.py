"""Command `init`: an example of a file that users write themselves."""

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


HERE = Path(__file__).parent
EXAMPLES = {
    Kind.base: (HERE / "two_links.py", "TwoLinks"),
    Kind.effect: (HERE / "gas_spring.py", "GasSpring"),
}


def init_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.py", help="file to write")],
    kind: Annotated[
        Kind | None,
        typer.Option(help="what of; default: an effect where the file's name says so, else a base"),
    ] = None,
) -> None:
    """Write an example for `diagnose`: a base model, two links in a vertical plane, or an effect,
    a gas spring."""
    if file.suffix != ".py":
        raise UsageError(f"{file}: is Python: name a file that ends in .py")
    kind = kind or (Kind.effect if "effect" in file.stem.lower() else Kind.base)
    example, name = EXAMPLES[kind]
    try:
        with file.open("x", encoding="utf-8") as written:
            written.write(example.read_text(encoding="utf-8"))
    except FileExistsError:
        raise OutputError(f"{file}: is there already: name another file") from None
    except OSError as error:
        raise OutputError(f"{file}: cannot be written ({error.strerror})") from None
    print(f"written  {file}\nuse it   flexhex diagnose RUN... --{kind.value} {file}:{name}")
