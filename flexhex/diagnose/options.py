"""Words of the command line that `diagnose` takes, and what must hold of them before it begins."""

from __future__ import annotations

import errno
import sys
import tempfile
from pathlib import Path
from typing import Any

from typer.core import TyperCommand

from flexhex.fmus.common.errors import UsageError

GREEDY = ("--locked",)
"""Options that take all words up to the next option."""


class Greedy(TyperCommand):
    """A command whose `--locked a b c` means `--locked a --locked b --locked c`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat a greedy option before each of its words."""
        return super().parse_args(ctx, repeated(args))


def repeated(args: list[str]) -> list[str]:
    """Words in which every greedy option stands before each of its values."""
    made: list[str] = []
    option, first = "", False
    for k, word in enumerate(args):
        if word == "--":
            return [*made, *args[k:]]
        if word.startswith("-") and len(word) > 1:
            option, first = (word, True) if word in GREEDY else ("", False)
            made.append(word)
        else:
            made += [word] if not option or first else [option, word]
            first = False
    return made


def interactive() -> bool:
    """Whether somebody sits there who can answer."""
    return sys.stdin.isatty()


def once_each(runs: list[Path], locked: list[Path]) -> None:
    """UsageError when a file is named twice: noise that repeats would be taken for an effect."""
    for option, paths in (("", runs), ("--locked ", locked)):
        twice = [p for k, p in enumerate(paths) if p.resolve() in {q.resolve() for q in paths[:k]}]
        if twice:
            raise UsageError(f"{option}{twice[0]} is given twice: name each run once")
    both = {path.resolve() for path in runs} & {path.resolve() for path in locked}
    if both:
        raise UsageError(f"{min(both).name} is given as a run and as a locked one: choose")


def writable(option: str, page: Path) -> None:
    """UsageError, before anything is computed, when a page cannot be written."""
    try:
        page.parent.mkdir(parents=True, exist_ok=True)
        if page.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a folder: name a file")
        with tempfile.TemporaryFile(dir=page.parent):
            pass
    except OSError as error:
        shown = page if option == "--report" else page.parent
        raise UsageError(f"{option} {shown}: cannot be written ({error.strerror})") from None
