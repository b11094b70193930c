"""Words of the command line that `diagnose` takes, and what must hold of them before it begins."""

from __future__ import annotations

import errno
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from typer import BadParameter
from typer.core import TyperArgument, TyperCommand

from flexhex.fmus.common.errors import OutputError, UsageError

GREEDY = ("--held-out", "--locked")
"""Options that take all words up to the next option."""


class Greedy(TyperCommand):
    """A command whose `--held-out a b c` means `--held-out a --held-out b --held-out c`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat a greedy option before each of its words. UsageError where none is left."""
        try:
            return super().parse_args(ctx, repeated(args))
        except BadParameter as error:
            # files are not looked at yet: it is missing
            if isinstance(error.param, TyperArgument) and (refused := swallowed(args)):
                raise UsageError(refused) from None
            raise


def repeated(args: list[str]) -> list[str]:
    """Words in which every greedy option stands before each of its values."""
    expanded: list[str] = []
    option, first = "", False
    for k, word in enumerate(args):
        if word == "--":
            return [*expanded, *args[k:]]
        if word.startswith("-") and len(word) > 1:
            option, first = (word, True) if word in GREEDY else ("", False)
            expanded.append(word)
        else:
            expanded += [word] if not option or first else [option, word]
            first = False
    return expanded


def swallowed(args: list[str]) -> str:
    """What is said where a greedy option took the words meant as arguments, or nothing."""
    words = repeated(args)
    for option in GREEDY:
        if count := words.count(option):
            took = "the only file" if count == 1 else f"all {count} files"
            return (
                f"{option} took {took}, as it takes all words up to the next option: put the runs"
                " that are fitted before it"
            )
    return ""


def interactive() -> bool:
    """Whether somebody sits there who can answer."""
    return sys.stdin.isatty()


def once_each(runs: list[Path], held_out: list[Path]) -> None:
    """UsageError when a file is named twice: its noise would count as repeatable."""
    for option, paths in (("", runs), ("--held-out ", held_out)):
        twice = [p for k, p in enumerate(paths) if p.resolve() in {q.resolve() for q in paths[:k]}]
        if twice:
            raise UsageError(f"{option}{twice[0]} is given twice: name each run once")
    both = {path.resolve() for path in runs} & {path.resolve() for path in held_out}
    if both:
        raise UsageError(
            f"{min(both).name} is given as a run to fit and as a held-out run: name it once"
        )


def refuse_inputs(outputs: Mapping[Path, str], inputs: Iterable[Path]) -> None:
    """UsageError for a file that is read and would be written: outputs with the option that names
    each."""
    read = {path.resolve(): path for path in inputs}
    for path, option in outputs.items():
        if path.resolve() in read:
            raise UsageError(
                f"{option} {path}: would be written over {read[path.resolve()]}, which is read:"
                " name another file"
            )


def writable(option: str, page: Path) -> None:
    """OutputError, before anything is computed, when a page cannot be written."""
    try:
        page.parent.mkdir(parents=True, exist_ok=True)
        if page.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a folder: name a file")
        with tempfile.TemporaryFile(dir=page.parent):
            pass
    except OSError as error:
        shown = page if option == "--report" else page.parent
        raise OutputError(f"{option} {shown}: cannot be written ({error.strerror})") from None


def refuse_unwritable(path: Path, option: str) -> None:
    """OutputError, before anything is computed, for a file that cannot be written; its folder is
    made. Tried, as rights do not say it of every folder."""
    try:
        path.resolve().parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.resolve().parent):
            possible = not path.is_dir()
    except OSError:
        possible = False
    if not possible:
        raise OutputError(f"{option} {path}: cannot be written: name a file in a folder of yours")
