"""Changes of an archive's members that the mistakes of mutants*.py are made of."""

from __future__ import annotations

from tests.conformity.archives import Change, Files

Mutants = dict[str, tuple[Change, str]]


def add(name: str, data: bytes) -> Change:
    """Put a further file into the archive."""

    def change(files: Files) -> None:
        files[name] = data

    return change


def move(old: str, new: str) -> Change:
    """Rename a member."""

    def change(files: Files) -> None:
        files[new] = files.pop(old)

    return change


def cut(member: str, share: float) -> Change:
    """Keep the first part of a member."""

    def change(files: Files) -> None:
        files[member] = files[member][: int(share * len(files[member]))]

    return change
