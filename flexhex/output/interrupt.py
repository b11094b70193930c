"""How any command ends that was stopped (Ctrl-C, a closed pipe) or called wrongly."""

from __future__ import annotations

import os
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from flexhex.output.usage import wrong_usage

STOPPED = 130
"""Exit code of a command that was stopped: 128 + SIGINT."""

BROKEN_PIPE = 141
"""Exit code of a command whose output nobody reads any more: 128 + SIGPIPE."""


class Interruptible(TyperGroup):
    """The commands of `flexhex`; Ctrl-C or a closed pipe ends any of them cleanly, and a wrong
    option is two lines."""

    def make_context(self, info_name: str | None, *args: Any, **more: Any) -> Any:
        """Read the options before the command."""
        with wrong_usage(info_name or "flexhex"):
            return super().make_context(info_name, *args, **more)

    def invoke(self, ctx: typer.Context) -> object:  # type: ignore[override]
        """Run the command."""
        try:
            with wrong_usage(context=ctx):
                result = super().invoke(ctx)
            sys.stdout.flush()
            return result
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
