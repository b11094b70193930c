"""Ctrl-C and closed pipes: how any command ends when nobody waits for it any more."""

from __future__ import annotations

import os
import sys

import typer
from typer.core import TyperGroup

STOPPED = 130
"""Exit code of a command that was stopped: 128 + SIGINT."""

BROKEN_PIPE = 141
"""Exit code of a command whose output nobody reads any more: 128 + SIGPIPE."""


class Interruptible(TyperGroup):
    """The commands of `flexhex`; Ctrl-C or a closed pipe ends any of them cleanly."""

    def invoke(self, ctx: typer.Context) -> object:  # type: ignore[override]
        """Run the command."""
        try:
            found = super().invoke(ctx)
            sys.stdout.flush()
            return found
        except KeyboardInterrupt:
            print("flexhex: stopped", file=sys.stderr)
            raise typer.Exit(STOPPED) from None
        except (BrokenPipeError, SystemExit) as error:
            # rich turns a broken pipe into SystemExit(1)
            if not isinstance(error, BrokenPipeError) and not isinstance(
                error.__context__, BrokenPipeError
            ):
                raise
            # what is still in the buffer is thrown away, else Python complains when it exits
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(BROKEN_PIPE) from None
