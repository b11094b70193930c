"""A wrong option or argument, in two plain lines."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

USAGE: type[Any] = typer.BadParameter.__bases__[0]
"""What every mistake in options and arguments derives from; typer does not name it."""
HELP = "NoArgsIsHelpError"
"""Class of the exception that shows the help where no command is named."""


def told(error: str, code: int) -> None:
    """With `--json` what is wrong on stdout, too, where programs read."""
    if "--json" in sys.argv:
        print(json.dumps({"error": error, "exit": code}, ensure_ascii=False))


@contextmanager
def wrong_usage(path: str = "", context: typer.Context | None = None) -> Iterator[None]:
    """A wrong option or argument is a line that says so and one that says where help is.

    path, context: of the command, where the exception does not know it.
    """
    try:
        yield
    except USAGE as error:
        if type(error).__name__ == HELP:
            raise
        if error.ctx is not None:
            path = error.ctx.command_path
        elif context is not None:
            path = f"{context.command_path} {context.invoked_subcommand or ''}".rstrip()
        text = error.format_message().replace("Value error, ", "")
        text = f"{text[:1].lower()}{text[1:].rstrip('.')}"
        print(f"{path}: {text}", file=sys.stderr)
        print(f"`{path} --help` lists what there is", file=sys.stderr)
        told(text, error.exit_code)
        raise typer.Exit(error.exit_code) from None
