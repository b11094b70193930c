"""Ctrl-C: one line and exit code 130, whatever command runs."""

from __future__ import annotations

import sys

import typer
from typer.core import TyperGroup

STOPPED = 130
"""Exit code of a command that was stopped: 128 + SIGINT."""


class Interruptible(TyperGroup):
    """The commands of `flexhex`; a KeyboardInterrupt in any of them ends it cleanly."""

    def invoke(self, ctx: typer.Context) -> object:  # type: ignore[override]
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            print("flexhex: stopped", file=sys.stderr)
            raise typer.Exit(STOPPED) from None
