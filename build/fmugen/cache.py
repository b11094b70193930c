"""What was built before, kept under a hash of everything that it depends on.

    <cache>/fmus/         whole FMUs
    <cache>/equations/    generated C of an FMU's equations
    <cache>/objects/      object files and small libraries

The cache is $FLEXHEX_CACHE, else $XDG_CACHE_HOME/flexhex, else ~/.cache/flexhex. It may be deleted
at any time. Several processes may use it side by side: a file appears under its name when it is
complete, and two that make the same file write the same bytes.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from flexhex.fmugen.pack import scratch_file

VARIABLE = "FLEXHEX_CACHE"
LIMIT = 500_000_000
"""Bytes; beyond it the files that were used least recently go."""
IN_USE = 3600.0
"""Files that were used in the last hour [s] stay: another process may be about to link them."""
_DIGEST = hashlib.sha256().digest_size
_SOURCES = ("fmus", "fmugen", "runtime")
_SUFFIXES = {".py", ".c", ".h", ".md", ".txt"}


def root() -> Path:
    """The folder of the cache; it need not exist."""
    named = os.environ.get(VARIABLE)
    if named:
        return Path(named).absolute()
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "flexhex"


def objects(fallback: Path) -> Path:
    """Folder for object files; `fallback` where the cache cannot be written to."""
    folder = root() / "objects"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder if os.access(folder, os.W_OK) else fallback


def key(*parts: object) -> str:
    """Hash of the parts; each one's repr must tell all that matters of it."""
    return hashlib.sha256("\0".join(map(repr, parts)).encode()).hexdigest()[:32]


@lru_cache
def sources() -> str:
    """Hash of all files of the package that determine what an FMU is."""
    package, digest = Path(__file__).parent.parent, hashlib.sha256()
    for part in _SOURCES:
        folder = (package / part).resolve()
        for path in sorted(p for p in folder.rglob("*") if p.suffix in _SUFFIXES):
            data = path.read_bytes()
            name = f"{part}/{path.relative_to(folder).as_posix()}"
            digest.update(f"{name}\0{len(data)}\0".encode() + data)
    return digest.hexdigest()


def kept(kind: str, name: str, make: Callable[[], bytes]) -> bytes:
    """The bytes kept as `<cache>/<kind>/<name>`, or those that `make` gives, kept from now on.

    A damaged file is made anew. A cache that cannot be written to is not used.
    """
    path = root() / kind / name
    value = _read(path)
    if value is None:
        value = make()
        _write(path, value)
    return value


def _read(path: Path) -> bytes | None:
    """The bytes of a file that is there and whole; it counts as used now."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    if hashlib.sha256(data[_DIGEST:]).digest() != data[:_DIGEST]:
        return None
    with contextlib.suppress(OSError):
        os.utime(path)
    return data[_DIGEST:]


def _write(path: Path, data: bytes) -> None:
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = scratch_file(path)
        scratch.write_bytes(hashlib.sha256(data).digest() + data)
        scratch.replace(path)
        _trimmed(root())


@lru_cache
def _trimmed(folder: Path) -> None:
    """Once a process: to look at every file takes long in a full cache."""
    trim(folder)


def trim(folder: Path, limit: int = LIMIT, in_use: float = IN_USE) -> None:
    """Delete the files used least recently until at most `limit` bytes are left."""
    files = []
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):
            about = path.stat()
            if path.is_file():
                files.append((about.st_mtime, about.st_size, path))
    total, now = sum(size for _, size, _ in files), time.time()
    for used, size, path in sorted(files):
        if total <= limit or now - used < in_use:
            return
        with contextlib.suppress(OSError):
            path.unlink()
        total -= size
