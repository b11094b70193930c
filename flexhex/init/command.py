"""Command `init`: an example of a file that users write themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.fmus.common.errors import OutputError, UsageError

EXAMPLE, NAME = Path(__file__).with_name("two_links.py"), "TwoLinks"


def init_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.py", help="file to write")],
) -> None:
    """Write an example of a base model, two links in a vertical plane, for `diagnose --base`."""
    if file.suffix != ".py":
        raise UsageError(f"{file}: a base model is Python: name a file that ends in .py")
    try:
        with file.open("x", encoding="utf-8") as written:
            written.write(EXAMPLE.read_text(encoding="utf-8"))
    except FileExistsError:
        raise OutputError(f"{file}: is there already: name another file") from None
    except OSError as error:
        raise OutputError(f"{file}: cannot be written ({error.strerror})") from None
    print(f"written  {file}\nuse it   flexhex diagnose RUN... --base {file}:{NAME}")
